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

cdef class Splitting:
    cdef const unsigned char[:, ::1] vectors
    cdef int[::1] order  # numbers of the vectors, leaf after leaf
    cdef unsigned char[:, ::1] centroids
    cdef long long[::1] spread  # sum of squared differences from the centroid
    cdef unsigned char[:, ::1] side  # scratch (2, n): 1 for vectors of the second half
    cdef int[::1] kept  # scratch (n,)
    cdef long long[:, ::1] total  # scratch, two vectors

cdef void wait(Tree tree, long long key, int node, Py_ssize_t most) noexcept nogil

cdef inline const unsigned char* vector(Splitting tree, Py_ssize_t i) noexcept nogil:
    """The vector that is the ith in order; here, or it cannot be inlined."""
    return &tree.vectors[tree.order[i], 0]

cdef void means(Splitting tree, Py_ssize_t start, Py_ssize_t stop, const unsigned char* side,
                Py_ssize_t child) noexcept nogil

cdef void halve(Splitting tree, Py_ssize_t start, Py_ssize_t stop,
                unsigned char* side) noexcept nogil
