cdef class Sight:
    cdef double variety
    cdef const int[:, ::1] laid
    cdef const int[:, ::1] seen
    cdef const int[::1] window
    cdef const int[::1] canvas
    cdef const int[::1] sample

cdef double shown_again(Sight sight, Py_ssize_t p, Py_ssize_t y, Py_ssize_t x,
                        Py_ssize_t source_y, Py_ssize_t source_x) noexcept nogil
