cdef enum:
    # The choices that a pixel of a box may have.
    NOTHING = 0
    OLD = 1
    NEW = 2
    EITHER = 3

    REACH = 2  # blocks around those that the cut passes
    STEP = 2  # so many halvings less at a time
