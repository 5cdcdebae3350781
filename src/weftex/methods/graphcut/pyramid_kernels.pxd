cdef Py_ssize_t run_of(const unsigned char* marks, Py_ssize_t at, Py_ssize_t end,
                       int mark) noexcept nogil

cdef double box_mismatch(const unsigned char[:, :, ::1] box, const unsigned char[:, ::1] known,
                         const unsigned char[:, :, ::1] sample, const unsigned char[:, ::1] usable,
                         Py_ssize_t top, Py_ssize_t left, bint whole, double most) noexcept nogil
