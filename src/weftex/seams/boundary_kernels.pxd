cdef class Band:
    cdef long long[:, ::1] error
    cdef long long[:, ::1] beyond
    cdef long long[:, ::1] total
    cdef int[:, ::1] came
    cdef int[::1] path

cdef void least_boundary(Band band, Py_ssize_t length, Py_ssize_t depth, Py_ssize_t begin,
                         Py_ssize_t end) noexcept nogil

# Squared difference of two pixels. Here, or it cannot be inlined.
cdef inline long long pixel_difference(
    const unsigned char[:, :, ::1] one, Py_ssize_t ay, Py_ssize_t ax,
    const unsigned char[:, :, ::1] other, Py_ssize_t by, Py_ssize_t bx
) noexcept nogil:
    cdef Py_ssize_t k
    cdef int d
    cdef long long total = 0
    for k in range(one.shape[2]):
        d = <int> one[ay, ax, k] - other[by, bx, k]
        total += d * d
    return total
