cdef enum:
    BLOCK = 64  # windows that lower bounds are taken of at a time
    STEP = 24  # bytes that are added to them at a time
    TERM = 6383  # the most that one byte adds: MOST + 4 * TERM < 2**16
    MOST = 40000  # the largest bound

cdef unsigned short bounds(const unsigned char* planes, const Py_ssize_t[::1] at,
                           const short[::1] value, const unsigned short[::1] weight,
                           const unsigned short[::1] cap, Py_ssize_t first,
                           Py_ssize_t last, unsigned short* out) noexcept nogil
