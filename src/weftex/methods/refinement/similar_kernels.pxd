cdef bint near(Py_ssize_t step, Py_ssize_t apart) noexcept nogil
