cdef class Sample:
    cdef const unsigned char[:, :, ::1] pixels
    cdef const unsigned char[:, :, ::1] turned
    cdef const unsigned char[:, ::1] usable
    cdef const int[::1] period
    cdef const int[::1] centers

cdef class Grid:
    cdef const long long[::1] rows
    cdef const long long[::1] columns
    cdef const int[::1] wrap
    cdef const long long[:, :, ::1] phase
    cdef const unsigned long long[:, ::1] bits
    cdef int[:, ::1] place

cdef int place_at(Sample sample, long long y, long long x) noexcept nogil

cdef int similar(Sample sample, Grid grid, const long long[:, ::1] steps, Py_ssize_t i,
                 Py_ssize_t j, Py_ssize_t k) noexcept nogil

cdef Py_ssize_t around(Grid grid, Py_ssize_t axis, Py_ssize_t at, Py_ssize_t step) noexcept nogil

cdef long long shown_again(Sample sample, int place, int other, long long dy, long long dx,
                           long long height, long long width) noexcept nogil

cdef int any_place(Sample sample, Grid grid, Py_ssize_t i, Py_ssize_t j) noexcept nogil
