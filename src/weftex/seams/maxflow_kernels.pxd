cdef enum:
    # Trees of a node, and what its parent may be beside a direction.
    SOURCE = 1
    SINK = 2
    ROOT = 4
    NOBODY = 5
    LOST = 6

# A node's fields: residual capacities by direction; that of the arc from the source, negative: to the
# sink; the distance to the root, as it was at this time stamp; the direction of its parent, or ROOT,
# NOBODY (in no tree) or LOST (an orphan); SOURCE or SINK; whether it is active. 32 bytes.
cdef struct Node:
    int[4] arcs
    int terminal
    int distance
    int stamp
    signed char parent
    signed char tree
    signed char waits
    signed char unused

cdef class Grid:
    cdef int[:, :, ::1] arcs
    cdef int[:, ::1] from_source
    cdef int[:, ::1] to_sink
    cdef Py_ssize_t height
    cdef Py_ssize_t width
    cdef Node[::1] nodes
    cdef int[::1] active
    cdef int[::1] orphans
    cdef Py_ssize_t[4] steps
    cdef int now

cdef Node* beside(Grid grid, Node* node, int d) noexcept nogil
cdef void put(int[::1] ring, Py_ssize_t i) noexcept nogil
cdef Py_ssize_t take(int[::1] ring) noexcept nogil
cdef void wake(Grid grid, Node* node) noexcept nogil
cdef void lose(Grid grid, Node* node) noexcept nogil
cdef int grow(Grid grid, Node* node) noexcept nogil
cdef int augment(Grid grid, Node* node, int d) noexcept nogil
cdef int distance_to_root(Grid grid, Node* node) noexcept nogil
cdef void adopt(Grid grid, Node* node) noexcept nogil
cdef long long plant(Grid grid) noexcept nogil
cdef long long max_flow(Grid grid, unsigned char[:, ::1] side, long long most) noexcept nogil
