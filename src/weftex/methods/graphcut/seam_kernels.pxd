cdef enum:
    # Costs weighed by gradients: a mean difference of SOFT levels on either side weighs like none.
    SCALE = 256
    SOFT = 32

cdef class Sample:
    cdef const unsigned char[:, ::1] pixels
    cdef const unsigned char[::1] joins
    cdef int height
    cdef int width
    cdef bint whole
    cdef bint by_gradients
    cdef const int[:, ::1] gradients

cdef class Picture:
    cdef unsigned char[:, ::1] pixels
    cdef int[::1] source
    cdef unsigned char[::1] done
    cdef const unsigned char[::1] known
    cdef signed char[::1] runs
    cdef int height
    cdef int width
    cdef bint wrap_y
    cdef bint wrap_x

cdef int beside(Picture picture, int p, int dy, int dx) noexcept nogil

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

cdef inline int cost_within(Sample sample, int apart, int old, int new, int d) noexcept nogil:
    """`seam_cost` where both pixels are in both patches, `apart` the sum of their differences."""
    cdef int gradient
    if not sample.by_gradients:
        return apart
    gradient = sample.gradients[d, old] + sample.gradients[d, new]
    return SCALE * apart // (gradient + SOFT * <int> sample.pixels.shape[1])

cdef inline int continued(Sample sample, int label, int d) noexcept nogil:
    """The place in the sample that a pixel's patch has beside it; -1 for none."""
    cdef int joins, step
    if label < 0:
        return -1
    joins = sample.joins[label] >> d
    if not joins & 1:
        return -1
    step = sample.width if d & 1 else 1
    if joins & 16:  # from the last row or column to the first one
        step -= sample.height * sample.width if d & 1 else sample.width
    return label - step if d & 2 else label + step

cdef long long seam_cost(Picture picture, Sample sample, int p, int q, int d, int label_p,
                         int label_q) noexcept nogil
