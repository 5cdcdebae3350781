cdef enum:
    REACH = 2  # blocks around those that the cut passes
    STEP = 2  # the number of halvings less at each step
