cdef void weigh_cell(const int[:, ::1] pixels, const int[:, ::1] weights, const int[:, ::1] spans,
                     const long long[:, ::1] missing, const int[:, ::1] holes,
                     int[:, ::1] plane) noexcept nogil

cdef void count_beside(const int[:, ::1] pixels, const int[::1] near, const int[::1] mirrored,
                       const int[::1] own, const long long[:, ::1] missing,
                       long long[:, :, ::1] sums) noexcept nogil

cdef long long weigh_places(const int[:, ::1] places, const int[::1] rows, const int[::1] columns,
                            Py_ssize_t v, Py_ssize_t u, const int[:, ::1] weights,
                            const int[::1] sizes) noexcept nogil
