cpdef Py_ssize_t causal_runs(Py_ssize_t y, Py_ssize_t x, Py_ssize_t width, bint wrap_x,
                            Py_ssize_t up, Py_ssize_t left, Py_ssize_t right,
                            int[:, ::1] runs) noexcept nogil

cdef void turn_runs(int[:, ::1] runs, Py_ssize_t n) noexcept nogil

cpdef Py_ssize_t gather_runs(const unsigned char[:, :, ::1] levels, Py_ssize_t y, Py_ssize_t x,
                            const int[:, ::1] runs, Py_ssize_t n,
                            unsigned char[::1] query) noexcept nogil

cpdef long long run_distance(const unsigned char[:, :, ::1] pixels, Py_ssize_t y, Py_ssize_t x,
                            const int[:, ::1] runs, Py_ssize_t n, const unsigned char[::1] query,
                            long long bound) noexcept nogil

cdef void copy_pixel(const unsigned char[:, :, ::1] sample, Py_ssize_t place,
                     unsigned char[:, :, ::1] pixels, int[:, ::1] source,
                     Py_ssize_t y, Py_ssize_t x) noexcept nogil
