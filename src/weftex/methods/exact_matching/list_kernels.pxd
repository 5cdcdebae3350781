from weftex.methods.exact_matching.color_kernels cimport ColorTree
from weftex.search.picture_kernels cimport Query

# The sample, and the lists of section 4.1; `ColorLists` says what the arrays hold.
cdef class Lists:
    cdef const unsigned char[:, :, ::1] pixels
    cdef const unsigned char[:, ::1] usable
    cdef const int[::1] period
    cdef const int[::1] centers
    cdef const unsigned char[:, :, ::1] coarse
    cdef ColorTree tree
    cdef const int[:, ::1] number
    cdef const long long[::1] radius
    cdef const int[:, ::1] offsets
    cdef const int[:, ::1] starts
    cdef const int[::1] groups
    cdef const int[::1] places
    # The colors looked up last: for each slot color, number of intervals, last stamp; the intervals.
    cdef int[:, ::1] kept
    cdef int[:, ::1] intervals

cdef long long near_lists(Lists lists, const int[::1] colors, int stamp, int[::1] slots) noexcept nogil

cdef int slot_of(Lists lists, int color, int stamp) noexcept nogil

cdef Py_ssize_t leader_of(const unsigned char[:, :, ::1] pixels, Query query,
                          const int[::1] places, const long long[::1] sums, Py_ssize_t i,
                          long long limit, const int[::1] heads, Py_ssize_t count) noexcept nogil
