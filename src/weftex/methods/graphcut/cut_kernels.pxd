cdef enum:
    REACH = 2  # blocks around those that the cut passes
    STEP = 2  # so many halvings less at a time
