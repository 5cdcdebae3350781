# A kd-tree over distinct colors; `ColorIndex` says what its arrays hold.
cdef class ColorTree:
    cdef const unsigned char[:, ::1] colors
    cdef const unsigned char[:, ::1] low
    cdef const unsigned char[:, ::1] high
    cdef const int[::1] rank
    cdef Py_ssize_t depth

cpdef Py_ssize_t near_colors(ColorTree tree, Py_ssize_t number, long long radius,
                            int[:, ::1] intervals, Py_ssize_t row) noexcept nogil

cdef Py_ssize_t nearest_colors(ColorTree tree, const unsigned char* color, Py_ssize_t wanted,
                               long long[::1] keys, int[::1] places) noexcept nogil

cdef long long box_distance(ColorTree tree, const unsigned char* color, Py_ssize_t node,
                            bint farthest) noexcept nogil

cdef Py_ssize_t nearer_child(ColorTree tree, const unsigned char* color,
                             Py_ssize_t node) noexcept nogil
