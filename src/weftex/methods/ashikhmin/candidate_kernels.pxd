from weftex.search.picture_kernels cimport Picture, Query, SampleWindows

cdef class PixelChoice:
    cdef Py_ssize_t half  # of a window's width
    cdef Py_ssize_t jumps  # random places that are always tried
    cdef Query query
    cdef int[::1] places  # of the candidates
    cdef const unsigned char[:, :, ::1] followed
    cdef const unsigned char[:, :, ::1] guide
    cdef long long guide_weight  # in 1/256
    cdef Py_ssize_t y
    cdef Py_ssize_t x
    cdef bint wrap_y
    cdef bint again  # the pixel was chosen before

cdef Py_ssize_t gather_candidates(SampleWindows sample, Picture picture, PixelChoice choice,
                                  const int[:, ::1] random_places, Py_ssize_t row) noexcept nogil

cdef Py_ssize_t best_candidate(SampleWindows sample, Picture picture, PixelChoice choice,
                               Py_ssize_t count) noexcept nogil

cdef long long guide_distance(Picture picture, PixelChoice choice, Py_ssize_t place) noexcept nogil
