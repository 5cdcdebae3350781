# A node's fields: residual capacities by direction; that of the arc from the source, negative: to the
# sink; the direction of its parent, or ROOT, NOBODY (in no tree) or LOST (an orphan); SOURCE or
# SINK; the distance to the root, as it was at this time stamp; whether it is active.
cdef struct Node:
    int[4] arcs
    int terminal
    int parent
    int tree
    int distance
    int stamp
    int waits

cdef class Capacities:
    cdef const int[:, :, ::1] arcs
    cdef const int[:, ::1] source
    cdef const int[:, ::1] sink
    cdef Py_ssize_t height
    cdef Py_ssize_t width

cdef class Trees:
    cdef Node[::1] nodes
    cdef int[::1] active
    cdef int[::1] orphans
    cdef Py_ssize_t width
    cdef int now

cdef long long minimum_cut(Capacities capacities, Trees trees,
                           unsigned char[:, ::1] side) noexcept nogil
