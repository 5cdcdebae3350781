from weftex.search.picture_kernels cimport Query

cdef class NearestWindows:
    cdef const unsigned char[:, :, ::1] pixels
    cdef const int[::1] centers
    cdef Py_ssize_t reach
    cdef const short[:, ::1] basis
    cdef const int[::1] offset
    cdef int shift
    cdef const short[:, ::1] features
    cdef double length
    cdef int[::1] query
    cdef short[::1] coordinates
    cdef int[::1] apart

cpdef Py_ssize_t nearest_window(NearestWindows whole, NearestWindows above, Query query,
                               const int[::1] near, Py_ssize_t near_count) noexcept nogil

cdef Py_ssize_t leading(NearestWindows search, Query query) noexcept nogil

cdef void bound_all(NearestWindows search, const unsigned char[::1] query) noexcept nogil

cdef long long farthest(NearestWindows search, long long distance) noexcept nogil

cdef Py_ssize_t nearest_within(NearestWindows search, bint bounded, Query query,
                               const int[::1] near, Py_ssize_t near_count) noexcept nogil
