from weftex.methods.graphcut.cost_kernels cimport Labeling
from weftex.seams.maxflow_kernels cimport Grid

cdef enum:
    # The choices that a pixel of a box may have.
    NOTHING = 0
    OLD = 1
    NEW = 2
    EITHER = 3

cdef enum:
    REACH = 2  # blocks around those that the cut passes
    STEP = 2  # by how much the exponent falls at each step

# The source is the new patch (the paper's B), the sink the old pixels (A). The source's arc to a
# block has its cost if it stays old, the block's arc to the sink its cost if it becomes new.
cdef class Graph(Grid):
    cdef Labeling labeling
    cdef const int[::1] rows
    cdef const int[::1] columns
    cdef const int[::1] from_rows
    cdef const int[::1] from_columns
    cdef unsigned char[:, ::1] choice  # of each pixel
    cdef unsigned char[:, ::1] side  # of each block: 1 on the new side of the cut
    cdef unsigned char[:, ::1] near  # scratch of `narrow`
    cdef int[::1] costs  # scratch of `add_within`
    cdef const int[:, ::1] prices  # of cells of the box: what a pixel costs that becomes new, or less
    cdef int cell_exponent  # a cell is 2**cell_exponent pixels wide
    cdef long long before  # the cost of the seams that the patch may change, before it

# Here, or they cannot be inlined.
cdef inline Py_ssize_t blocks(Py_ssize_t length, int exponent) noexcept nogil:
    """The number of blocks along a side; they are 2**exponent pixels wide, the last one less."""
    return ((length - 1) >> exponent) + 1

cdef inline int on_canvas(Graph graph, Py_ssize_t i, Py_ssize_t j) noexcept nogil:
    """The pixel of the canvas, flat, at a place of the box."""
    return graph.rows[i] * graph.labeling.width + graph.columns[j]

cdef inline int in_sample(Graph graph, Py_ssize_t i, Py_ssize_t j) noexcept nogil:
    """The label that the patch has at a place of the box."""
    return graph.from_rows[i] * graph.labeling.columns + graph.from_columns[j]

cdef Py_ssize_t mark_choices(Graph graph) noexcept nogil

cdef long long add_pair(Graph graph, Py_ssize_t i, Py_ssize_t j, int d, int exponent) noexcept nogil

cdef void add_within(Graph graph, Py_ssize_t i, Py_ssize_t first, Py_ssize_t count, int d,
                     int exponent) noexcept nogil

cdef long long add_run(Graph graph, Py_ssize_t i, Py_ssize_t first, Py_ssize_t end,
                       int exponent) noexcept nogil

cdef bint is_straight(Graph graph, Py_ssize_t i, Py_ssize_t first, Py_ssize_t last) noexcept nogil

cdef long long add_prices(Graph graph, int exponent) noexcept nogil

cdef long long build(Graph graph, int exponent, bint by_runs) noexcept nogil

cdef long long cut(Graph graph, int exponent, bint by_runs, long long most) noexcept nogil

cdef void narrow(Graph graph, int exponent) noexcept nogil

cdef Py_ssize_t paste(Graph graph) noexcept nogil
