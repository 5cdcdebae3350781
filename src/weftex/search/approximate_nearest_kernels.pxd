cpdef void square_means(const unsigned char[:, :, ::1] canvas, Py_ssize_t y, Py_ssize_t x,
                      const int[:, ::1] squares, Py_ssize_t side, int[::1] means) noexcept nogil

cdef Py_ssize_t offer(long long key, int place, Py_ssize_t count, Py_ssize_t wanted,
                      long long* keys, int* places) noexcept nogil

cpdef Py_ssize_t nearest_by_squares(const unsigned char[:, :, :, :, ::1] nodes,
                                  const int[:, ::1] squares, const int[::1] query,
                                  const unsigned char[:, ::1] usable, Py_ssize_t wanted,
                                  long long[::1] distances, int[::1] corners) noexcept nogil

cpdef void project(const short[:, ::1] basis, const int[::1] offset, int shift,
                  const int[::1] query, short[::1] coordinates) noexcept nogil

cdef void all_distances(const short[:, ::1] coordinates, const short[::1] query,
                        int[::1] total) noexcept nogil

cpdef Py_ssize_t nearest_by_coordinates(const short[:, ::1] coordinates, const int[::1] at,
                                       const short[::1] query, Py_ssize_t wanted,
                                       long long[::1] distances, int[::1] corners) noexcept nogil

cdef void some_distances(const short[:, ::1] coordinates, const short[::1] query, Py_ssize_t start,
                         Py_ssize_t n, int* total) noexcept nogil
