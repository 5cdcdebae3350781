# Sum of squared differences of two rows of bytes. Here, or it cannot be inlined.
cdef inline long long squared(
    const unsigned char* a, const unsigned char* b, Py_ssize_t n
) noexcept nogil:
    cdef Py_ssize_t start = 0, stop, i
    cdef long long total = 0
    cdef int part
    cdef short d
    while start < n:
        stop = start + 16384 if start + 16384 < n else n  # 16384 * 255**2 < 2**31
        part = 0
        for i in range(start, stop):
            d = <short> a[i] - <short> b[i]
            part += <int> d * d
        total += part
        start = stop
    return total

# Sum of w d**2 of two rows of bytes, with weights w up to 127.
cdef inline long long weighted_squares(
    const unsigned char* a, const unsigned char* b, const short* w, Py_ssize_t n
) noexcept nogil:
    cdef Py_ssize_t start = 0, stop, i
    cdef long long total = 0
    cdef int part
    cdef short d, e
    while start < n:
        stop = start + 256 if start + 256 < n else n  # 256 * 127 * 255**2 < 2**31
        part = 0
        for i in range(start, stop):
            d = <short> a[i] - <short> b[i]
            e = <short> (w[i] * d)  # 127 * 255 < 2**15
            part += <int> e * d
        total += part
        start = stop
    return total
