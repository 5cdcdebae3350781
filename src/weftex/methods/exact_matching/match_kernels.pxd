from weftex.methods.exact_matching.list_kernels cimport Lists
from weftex.search.picture_kernels cimport Picture, Query

cdef class PixelSearch:
    # Which windows are compared.
    cdef bint causal
    cdef Py_ssize_t reach
    cdef Py_ssize_t coarse_reach
    cdef Py_ssize_t repeat_distance
    cdef long long most  # windows of the lists that are compared; 0 is all
    # The next coarser level at the picture's size, and the places that it leads to.
    cdef bint guided
    cdef const unsigned char[:, :, ::1] coarse
    cdef const unsigned char[:, ::1] coarse_done  # 1 everywhere
    cdef const int[:, ::1] suggested
    # The pixel, the window around it, and that of the coarser level.
    cdef Py_ssize_t y
    cdef Py_ssize_t x
    cdef unsigned long long bits  # random ones
    cdef Query query
    cdef Query coarse_query
    # Its direct neighbors, and the place of the coarser level after them.
    cdef int[::1] color  # -1: there is none
    cdef Py_ssize_t[::1] goes_on  # where the sources go on; -1: nowhere
    cdef int[::1] slots  # where `Lists.intervals` has the lists; -1: nowhere
    # The best match so far.
    cdef long long best  # its distance; -1: there is none
    cdef unsigned int best_key
    cdef Py_ssize_t chosen
    cdef bint coherent  # a neighbor's source goes on there
    cdef long long compared
    cdef Py_ssize_t apart
    # Of each pixel of the picture, and of each place of the lists.
    cdef int[:, ::1] colors  # the number of its color, or -1
    cdef int[::1] last  # the pixel that it was last copied to, or -1
    cdef int[::1] seen  # the stamp of the search that met it last
    cdef int stamp

cdef void look_around(Lists lists, Picture picture, PixelSearch search) noexcept nogil

cdef void gather_windows(Picture picture, PixelSearch search) noexcept nogil

cdef void find_best(Lists lists, Picture picture, PixelSearch search) noexcept nogil

cdef void compare_coherent(Lists lists, Picture picture, PixelSearch search) noexcept nogil

cdef void compare_listed(Lists lists, Picture picture, PixelSearch search) noexcept nogil

cdef long long compare_share(Lists lists, Picture picture, PixelSearch search,
                             long long share) noexcept nogil

cdef void compare_group(Lists lists, Picture picture, PixelSearch search, Py_ssize_t group,
                        unsigned int key) noexcept nogil

cdef long long window_distance(Lists lists, Picture picture, PixelSearch search,
                               Py_ssize_t place) noexcept nogil

cdef bint repeats(Picture picture, PixelSearch search, Py_ssize_t place) noexcept nogil

cdef void copy_chosen(Lists lists, Picture picture, PixelSearch search) noexcept nogil
