cimport cython

ctypedef fused value:
    unsigned char
    unsigned short
    float
    double

cdef void paste(value[:, :, ::1] out, const value[:, :, ::1] source,
                Py_ssize_t top, Py_ssize_t left, Py_ssize_t height, Py_ssize_t width,
                Py_ssize_t y, Py_ssize_t x, Py_ssize_t sy, Py_ssize_t sx,
                const unsigned short[:, :, ::1] weights, Py_ssize_t zone,
                const unsigned short[:, ::1] cuts, Py_ssize_t k,
                Py_ssize_t scale, bint alpha) noexcept nogil
