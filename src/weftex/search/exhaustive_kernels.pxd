cdef enum:
    BLOCK_WINDOWS = 64  # windows that lower bounds are taken of at a time
    STEP_TERMS = 24  # terms that are added to them at a time
    LARGEST_TERM = 6383  # LARGEST_BOUND + 4 * LARGEST_TERM < 2**16
    LARGEST_BOUND = 40000

cdef class Terms:
    cdef Py_ssize_t[::1] at  # where a term's bytes begin in the planes
    cdef short[::1] value
    cdef unsigned short[::1] weight
    cdef unsigned short[::1] cap  # of the squared difference

cdef unsigned short bounds(const unsigned char* planes, Terms terms, Py_ssize_t first,
                           Py_ssize_t last, unsigned short* out) noexcept nogil
