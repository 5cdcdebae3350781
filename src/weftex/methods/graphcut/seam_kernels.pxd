cdef class Sample:
    cdef const unsigned char[:, ::1] pixels
    cdef const unsigned char[::1] joins
    cdef int height
    cdef int width
    cdef bint by_gradients

cdef class Picture:
    cdef unsigned char[:, ::1] pixels
    cdef int[::1] source
    cdef unsigned char[::1] done
    cdef const unsigned char[::1] known
    cdef int height
    cdef int width
    cdef bint wrap_y
    cdef bint wrap_x

cdef int beside(Picture picture, int p, int dy, int dx) noexcept nogil

# Here, or it cannot be inlined.
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
