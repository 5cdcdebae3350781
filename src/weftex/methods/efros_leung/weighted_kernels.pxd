from weftex.search.picture_kernels cimport Picture, Query, SampleWindows

cdef enum:
    BLOCK_WINDOWS = 64  # windows that lower bounds are taken of at a time
    STEP_TERMS = 24  # terms that are added to them at a time
    LARGEST_TERM = 6383  # LARGEST_BOUND + 4 * LARGEST_TERM < 2**16
    LARGEST_BOUND = 40000

cdef class WeightedWindows:
    cdef const unsigned char[::1] flat  # the pixels row by row, and a stride more
    cdef const short[:, ::1] weights
    cdef Py_ssize_t stride  # bytes of a row of a window, filled up to whole vectors
    cdef Py_ssize_t width  # of the sample
    cdef Py_ssize_t channels
    cdef Py_ssize_t reach
    cdef const unsigned char[:, ::1] planes  # of one channel each, with a margin
    cdef const int[::1] starts  # of blocks of flat indices that hold all windows
    cdef const unsigned char[::1] allowed  # `usable` row by row, and a block more
    cdef const int[:, ::1] order  # places in a window, the heaviest first

cdef class Template:
    cdef Query query
    cdef unsigned char[::1] values  # a row of the window is a stride
    cdef short[::1] weights  # of each value; 0 where nothing is known
    cdef int[::1] rows  # their number, then the rows with anything known, the nearest first
    cdef Py_ssize_t[::1] at  # where the bytes of a term begin in the planes
    cdef short[::1] value  # of a term
    cdef unsigned short[::1] weight
    cdef unsigned short[::1] cap  # of the squared difference
    cdef unsigned short[:, ::1] lower  # bounds of each block's windows
    cdef unsigned short[::1] least  # of a block
    cdef int[::1] places  # windows that were compared; -1 for none
    cdef long long[::1] distances

cdef long long copy_known(Picture picture, WeightedWindows windows, Py_ssize_t y, Py_ssize_t x,
                          Template template) noexcept nogil

cdef long long window_distance(WeightedWindows windows, Py_ssize_t place, Template template,
                               long long bound) noexcept nogil

cdef long long pick_terms(WeightedWindows windows, Template template,
                          long long limit) noexcept nogil

cdef unsigned short term(short byte, short value, unsigned short weight,
                         unsigned short cap) noexcept nogil

cdef unsigned short bounds(const unsigned char* planes, Template template, Py_ssize_t first,
                           Py_ssize_t last, unsigned short* out) noexcept nogil

cdef long long largest_bound(long long limit, long long scale) noexcept nogil

cdef long long largest_accepted(long long best, double tolerance) noexcept nogil

cdef long long nearest_coherent(Picture picture, SampleWindows sample, WeightedWindows windows,
                                Py_ssize_t y, Py_ssize_t x, Template template) noexcept nogil

cdef Py_ssize_t list_within(WeightedWindows windows, Template template, long long best,
                            double tolerance) noexcept nogil
