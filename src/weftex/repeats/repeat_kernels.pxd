cdef void mark(int[:, ::1] marks, int level, int top, int bottom, int left,
               int right) noexcept nogil

cdef void weigh_cell(const int[:, ::1] pixels, const int[:, ::1] weights, const int[:, ::1] spans,
                     const long long[:, ::1] missing, const int[:, ::1] holes,
                     int[:, ::1] plane) noexcept nogil

cdef void count_beside(const int[:, ::1] pixels, const int[::1] near, const int[::1] mirrored,
                       const int[::1] own, const long long[:, ::1] missing,
                       long long[:, :, ::1] sums) noexcept nogil
