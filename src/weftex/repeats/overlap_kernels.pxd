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
