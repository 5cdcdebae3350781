cdef Py_ssize_t offer_place(Py_ssize_t place, Py_ssize_t count, int[::1] places) noexcept nogil
