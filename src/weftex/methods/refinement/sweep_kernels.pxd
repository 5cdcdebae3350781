from weftex.search.picture_kernels cimport Picture, Query, SampleWindows

cdef class Sources:
    cdef Py_ssize_t reach  # of a window
    cdef const int[::1] sample_index  # of each padded pixel
    cdef const int[::1] padded_index  # of each pixel of the sample
    cdef const int[:, ::1] similar  # sample indices of the pixels most like each
    cdef long long margin  # factor of their distances in 1/256
    cdef const int[::1] cells  # of each pixel of the sample
    cdef int[::1] used  # how often each cell is used
    cdef const int[::1] capacity  # and may be
    cdef long long weight  # of using one too often

cdef bint take(Picture picture, SampleWindows sample, Py_ssize_t y, Py_ssize_t x,
               Py_ssize_t place) noexcept nogil

cdef long long excess(Sources sources, Py_ssize_t cell) noexcept nogil

cdef Py_ssize_t gather_coherent(Picture picture, SampleWindows sample, Query query, int[::1] candidates,
                                Py_ssize_t y, Py_ssize_t x, Py_ssize_t reach) noexcept nogil

cdef Py_ssize_t gather_similar(SampleWindows sample, Sources sources, int[::1] candidates,
                               Py_ssize_t coherent) noexcept nogil

cdef void look(Picture picture, Query query, Py_ssize_t y, Py_ssize_t x,
               Py_ssize_t reach) noexcept nogil
