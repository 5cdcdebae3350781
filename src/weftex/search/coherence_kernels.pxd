from weftex.search.vocabulary_kernels cimport Picture, Query, Sample

cdef Py_ssize_t coherent_places(Picture picture, Sample sample, Py_ssize_t y, Py_ssize_t x,
                                Query query, int[::1] places, Py_ssize_t count) noexcept nogil
