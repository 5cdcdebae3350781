cdef enum:
    BLOCK = 64  # windows that lower bounds are taken of at a time

cdef unsigned short bounds(const unsigned char* planes, const Py_ssize_t[::1] at,
                           const short[::1] value, const unsigned short[::1] weight,
                           Py_ssize_t wanted, unsigned short* out) noexcept nogil
