cimport cython

ctypedef fused value:
    unsigned char
    unsigned short
    float
    double

ctypedef fused real:
    float
    double

cdef int ALPHA, VECTORS, LABELS

cdef enum:  # sides of a patch, in the order of their cuts in a row of `Layout.cuts`
    LEFT, RIGHT, TOP, BOTTOM

# Where the cut of a side begins in that row.
cdef inline Py_ssize_t start_of(Py_ssize_t side, Py_ssize_t rows, Py_ssize_t columns) noexcept nogil:
    return side * rows if side < TOP else 2 * rows + (side - TOP) * columns

cdef class Layout:
    cdef const int[:, ::1] placements
    cdef const unsigned short[:, :, ::1] weights
    cdef const unsigned short[:, ::1] cuts
    cdef Py_ssize_t height
    cdef Py_ssize_t width
    cdef Py_ssize_t top
    cdef Py_ssize_t left
    cdef Py_ssize_t scale
    cdef int mixing
    cdef double middle

cdef bint stretch(double* vector, double to, double middle, value* out) noexcept nogil
cdef double length(const value* vector, double middle) noexcept nogil
cdef double middle_of(value* sort, double given) noexcept nogil

cdef void paste(value[:, :, ::1] out, const value[:, :, ::1] source, Layout layout,
                Py_ssize_t k, Py_ssize_t zone) noexcept nogil
