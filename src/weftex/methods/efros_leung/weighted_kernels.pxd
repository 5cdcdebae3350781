cdef enum:
    BLOCK_WINDOWS = 64  # windows that lower bounds are taken of at a time
    STEP_TERMS = 24  # terms that are added to them at a time
    LARGEST_TERM = 6383  # LARGEST_BOUND + 4 * LARGEST_TERM < 2**16
    LARGEST_BOUND = 40000
