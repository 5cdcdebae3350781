cdef class Tree:
    cdef const unsigned char[:, ::1] rows  # the vectors, leaf after leaf
    cdef const int[::1] places  # of the rows
    cdef const int[:, ::1] nodes  # first child or -1, first and last row + 1
    cdef const unsigned char[:, ::1] centroids
    cdef long long[::1] keys  # scratch: distances of nodes that wait to be searched, ascending
    cdef int[::1] waiting  # these nodes
    cdef Py_ssize_t first, last  # which of them still wait
    cdef public unsigned char[::1] query  # the vector that is searched
    cdef int[:, ::1] spans  # first byte and number of bytes of what is known of it
    cdef Py_ssize_t known  # number of the spans

cpdef Py_ssize_t nearest(Tree tree, Py_ssize_t leaves) noexcept nogil
