cdef long long look(const unsigned char[:, :, ::1] levels, const unsigned char[:, ::1] done,
                    bint wrap_y, bint wrap_x, Py_ssize_t y, Py_ssize_t x,
                    const short[:, ::1] weights, Py_ssize_t stride, int[:, ::1] runs,
                    unsigned char[::1] query, short[::1] known, int[::1] rows) noexcept nogil

cdef long long window_distance(const unsigned char[::1] flat, Py_ssize_t place, Py_ssize_t width,
                               Py_ssize_t channels, Py_ssize_t reach, Py_ssize_t stride,
                               const unsigned char[::1] query, const short[::1] known,
                               const int[::1] rows, long long bound) noexcept nogil

cdef long long limit_of(long long best, double tolerance) noexcept nogil

cdef Py_ssize_t draw_one(int[::1] found, long long[::1] distances, Py_ssize_t count,
                         long long limit, unsigned long long bits) noexcept nogil
