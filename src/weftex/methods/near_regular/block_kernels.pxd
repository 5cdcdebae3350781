cdef int settled(const unsigned char[:, ::1] usable, const int[::1] period,
                 long long y, long long x) noexcept nogil

cdef int similar(const unsigned char[:, ::1] usable, const int[::1] period,
                 const long long[:, ::1] steps, long long y, long long x,
                 Py_ssize_t k) noexcept nogil

cdef Py_ssize_t around(Py_ssize_t i, Py_ssize_t step, Py_ssize_t count, bint wraps) noexcept nogil

cdef long long shown_again(int place, int other, Py_ssize_t width, long long dy, long long dx,
                           long long height, long long breadth) noexcept nogil
