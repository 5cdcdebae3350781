cdef Py_ssize_t coherent_places(const int[:, ::1] source, Py_ssize_t y, Py_ssize_t x,
                                const int[:, ::1] runs, Py_ssize_t n,
                                const unsigned char[:, ::1] usable, const int[::1] period,
                                int[::1] places, Py_ssize_t count) noexcept nogil
