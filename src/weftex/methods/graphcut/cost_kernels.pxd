cdef enum:
    WHITE = 255  # the largest difference of a channel
    SCALE = 256  # steps of a cost that is divided by gradients
    SOFT = 32  # added to the gradient for each channel: seams in flat parts have a finite cost

cdef class Labeling:
    # The canvas.
    cdef unsigned char[:, ::1] pixels
    cdef int[::1] labels
    cdef unsigned char[::1] done
    cdef const unsigned char[::1] fixed
    cdef signed char[::1] runs
    cdef int height
    cdef int width
    cdef bint wrap_y
    cdef bint wrap_x
    # The sample.
    cdef const unsigned char[:, ::1] colors
    cdef const unsigned char[::1] usable
    cdef const unsigned char[::1] joins
    cdef const int[:, ::1] gradients
    cdef bint by_gradients
    cdef int rows
    cdef int columns
    cdef bint whole

cdef int neighbor(Labeling labeling, int p, int dy, int dx) noexcept nogil

# Here, or they cannot be inlined.
cdef inline int difference(const unsigned char* a, const unsigned char* b,
                           Py_ssize_t channels) noexcept nogil:
    """Sum of absolute differences of two pixels: a metric, and exact."""
    cdef Py_ssize_t k
    cdef int total = 0
    if channels == 3:  # most pictures; the loop for any number is slower
        return (abs(<int> a[0] - <int> b[0]) + abs(<int> a[1] - <int> b[1])
                + abs(<int> a[2] - <int> b[2]))
    for k in range(channels):
        total += abs(<int> a[k] - <int> b[k])
    return total

cdef inline int divided(int cost, int gradient, int channels) noexcept nogil:
    """M' of section 5, rounded down: the cost of a seam divided by the gradients across it."""
    # Exact, and faster than a division of integers.
    return <int> (<double> (SCALE * cost) / (gradient + SOFT * channels))

cdef inline int continued(Labeling labeling, int label, int d) noexcept nogil:
    """The sample's pixel beside a label in direction d, or -1 where the sample ends."""
    cdef int joins, step
    if label < 0:
        return -1
    joins = labeling.joins[label] >> d
    if not joins & 1:
        return -1
    step = labeling.columns if d & 1 else 1
    if joins & 16:  # from the last row or column to the first one
        step -= labeling.rows * labeling.columns if d & 1 else labeling.columns
    return label - step if d & 2 else label + step

cdef long long seam_cost(Labeling labeling, int p, int q, int d, int label_p,
                         int label_q) noexcept nogil

cdef bint may_change(Labeling labeling, int p) noexcept nogil
cdef bint is_joined(Labeling labeling, int p, int d, bint last) noexcept nogil
cdef void update_row(Labeling labeling, int y, int first, int last) noexcept nogil
cdef void update_runs(Labeling labeling, const int[::1] rows,
                      const int[::1] columns) noexcept nogil
