cimport cython

ctypedef fused value:
    unsigned char
    unsigned short
    float
    double

ctypedef fused real:
    float
    double

cdef class Layout:
    cdef const int[:, ::1] placements
    cdef const unsigned short[:, :, ::1] weights
    cdef const unsigned short[:, ::1] cuts
    cdef Py_ssize_t height
    cdef Py_ssize_t width

cdef class View:
    cdef Py_ssize_t top
    cdef Py_ssize_t left
    cdef Py_ssize_t scale
    cdef bint alpha

cdef void paste(value[:, :, ::1] out, const value[:, :, ::1] source, Layout layout,
                Py_ssize_t k, Py_ssize_t zone, View view) noexcept nogil
