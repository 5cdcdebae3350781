# Of two boxes (y, x) apart in the sample and (down, right) apart on the canvas, the number of the
# sample's pixels that both show; -1 if they continue each other, which repeats nothing.
cdef inline long long repeated_pixels(
    long long y, long long x, long long down, long long right, long long height, long long width
) noexcept nogil:
    if y == down and x == right:
        return -1
    y = y if y >= 0 else -y
    x = x if x >= 0 else -x
    return (height - y) * (width - x) if y < height and x < width else 0

cdef enum:  # marks of `exclude_repeats`
    REPEATS = 1
    CONTINUES = 2

cdef void exclude_repeats(const int[:, ::1] placements, const int[::1] around, Py_ssize_t p,
                      Py_ssize_t apart, bint leave, const int[::1] places, Py_ssize_t width,
                      unsigned char[::1] excluded) noexcept nogil

cdef Py_ssize_t best_unrepeated(const long long[::1] keys, unsigned char[::1] excluded,
                                double dearer) noexcept nogil
