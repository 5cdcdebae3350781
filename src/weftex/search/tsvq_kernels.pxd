cdef Py_ssize_t nearest(const unsigned char[:, ::1] rows, const int[::1] places,
                        const int[:, ::1] nodes, const unsigned char[:, ::1] centroids,
                        const unsigned char[::1] query, const int[:, ::1] spans, Py_ssize_t n,
                        Py_ssize_t leaves, long long[::1] keys, int[::1] pending) noexcept nogil
