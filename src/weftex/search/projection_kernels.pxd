cdef class Components:
    cdef const unsigned char[::1] mean
    cdef const short[:, :, ::1] basis
    cdef const long long[::1] mean_product
    cdef const int[::1] offset
    cdef const short[:, ::1] features
    cdef int shift
    cdef short[::1] difference
    cdef long long[::1] totals
    cdef short[::1] coordinates

cdef void run_coordinates(Components components, const int[:, ::1] runs, Py_ssize_t count,
                          const unsigned char[::1] query) noexcept nogil
