from weftex.methods.wei_levoy.tsvq_kernels cimport Tree
from weftex.search.picture_kernels cimport Picture

cdef void gather_window(Picture level, Py_ssize_t y, Py_ssize_t x, const int[:, ::1] offsets,
                        Py_ssize_t first, Tree tree) noexcept nogil
