from weftex.search.zone_kernels cimport Shortlist

cdef enum:  # where candidates come from
    ALL = 0  # all windows
    BLOCKS = 1  # the nearest in the low resolution (section 3.2)
    COMPONENTS = 2  # the nearest in its principal components (section 3.3)
    TREE = 3  # a kd-tree (section 3.1), which has listed them

cdef class ZoneWindows:
    cdef int source
    cdef const unsigned char[:, ::1] usable
    cdef const int[::1] positions
    cdef Py_ssize_t area
    cdef const int[:, ::1] runs
    cdef const int[:, ::1] blocks
    cdef Py_ssize_t side
    cdef const int[::1] bands
    cdef const unsigned char[:, :, :, :, ::1] nodes
    cdef const short[:, ::1] basis
    cdef const int[::1] offset
    cdef int shift
    cdef const short[:, ::1] features

cdef Py_ssize_t list_candidates(const unsigned char[:, :, ::1] canvas, Py_ssize_t y, Py_ssize_t x,
                                ZoneWindows windows, Shortlist found) noexcept nogil

cdef Py_ssize_t climb(const unsigned char[:, :, ::1] pixels, const unsigned char[:, :, ::1] turned,
                      ZoneWindows windows, Py_ssize_t count, Shortlist found) noexcept nogil
