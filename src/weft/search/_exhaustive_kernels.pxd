cdef enum:
    BLOCK = 64  # windows that lower bounds are taken of at a time
