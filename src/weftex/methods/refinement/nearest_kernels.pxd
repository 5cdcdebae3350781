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
