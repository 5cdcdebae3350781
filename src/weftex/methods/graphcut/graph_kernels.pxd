from weftex.methods.graphcut.seam_kernels cimport Picture, Sample, continued, cost_within
from weftex.seams.maxflow_kernels cimport Capacities, Trees

cdef enum:
    # The choices that a pixel of a box may have.
    NOTHING = 0
    OLD = 1
    NEW = 2
    EITHER = 3
    # The kind of a block is the choice of all its pixels if they are NEW, or EITHER and no old seam
    # begins in them; or
    MIXED = 4

cdef class Patch:
    cdef const int[::1] rows
    cdef const int[::1] columns
    cdef const int[::1] from_rows
    cdef const int[::1] from_columns

cdef class Graph:
    cdef int[:, :, ::1] arcs  # to the right, lower, left and upper neighbor
    cdef int[:, ::1] old  # from the source: the price of a block that stays old
    cdef int[:, ::1] new  # to the sink: the price of one that becomes new
    cdef unsigned char[:, ::1] choice  # of each pixel
    cdef int[:, ::1] apart  # of each pixel that may be EITHER: how far its colors are apart
    cdef unsigned char[:, ::1] side  # of each block: 1 inside the cut
    cdef unsigned char[:, ::1] shown  # of each block: OLD and NEW, if it has such pixels; or its kind
    cdef unsigned char[:, ::1] along  # likewise of it and of those beside it
    cdef Capacities capacities
    cdef Trees trees
    cdef unsigned char[:, ::1] bytes  # of two rows: how far the colors of pixels are apart
    cdef int[:, ::1] sums  # of a row's blocks or pixels: what they cost; of all rows: see `paste`
    cdef long long before  # the cost of the seams that a patch may change, before it

# Here, or they cannot be inlined.
cdef inline Py_ssize_t blocks(Py_ssize_t length, int halvings) noexcept nogil:
    """How many blocks there are along a side; they are 2**halvings pixels wide, or the rest."""
    return ((length - 1) >> halvings) + 1

cdef inline int on_canvas(Picture picture, Patch patch, Py_ssize_t i, Py_ssize_t j) noexcept nogil:
    """A pixel of the box, flat."""
    return patch.rows[i] * picture.width + patch.columns[j]

cdef inline int in_sample(Sample sample, Patch patch, Py_ssize_t i, Py_ssize_t j) noexcept nogil:
    """What the patch has there, flat."""
    return patch.from_rows[i] * sample.width + patch.from_columns[j]

cdef inline unsigned char choice_of(Picture picture, Sample sample,
                                    const unsigned char[::1] usable, int p,
                                    int label) noexcept nogil:
    """The choice that a pixel of the canvas has where a patch has this label."""
    if not (sample.whole or usable[label]) or (picture.done[p] and picture.known[p]):
        return OLD if picture.done[p] else NOTHING
    return EITHER if picture.done[p] else NEW

cdef inline bint add_within(Sample sample, Patch patch, Graph graph, Py_ssize_t i, Py_ssize_t j,
                            int d, int halvings, int label, int apart) noexcept nogil:
    """`add_pair` where both pixels are in the old patch, if they are in the new one too.

    Then a and b are the same, and c is 0. `label` is the first pixel's, `apart` by how much the
    colors of both differ between the patches.
    """
    cdef Py_ssize_t v = i + d, u = j + 1 - d
    cdef int new = in_sample(sample, patch, i, j)
    cdef int cost
    if continued(sample, new, d) != in_sample(sample, patch, v, u):
        return False
    cost = cost_within(sample, apart, label, new, d)
    graph.arcs[v >> halvings, u >> halvings, d + 2] += cost
    graph.arcs[i >> halvings, j >> halvings, d] += cost
    return True

cdef long long add_outside(Picture picture, Sample sample, Patch patch, Graph graph, Py_ssize_t i,
                           Py_ssize_t j, int d, int may, int halvings) noexcept nogil

cdef long long add_pair(Picture picture, Sample sample, Patch patch, Graph graph, Py_ssize_t i,
                        Py_ssize_t j, int d, int p_may, int q_may, int halvings) noexcept nogil

cdef void clear(Patch patch, Graph graph, int halvings) noexcept nogil

cdef long long build(Picture picture, Sample sample, Patch patch, Graph graph,
                     int halvings) noexcept nogil
