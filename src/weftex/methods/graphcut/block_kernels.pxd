from weftex.methods.graphcut.graph_kernels cimport Graph, Patch
from weftex.methods.graphcut.seam_kernels cimport Picture, Sample

cdef Py_ssize_t choose(Picture picture, const unsigned char[::1] usable, Sample sample, Patch patch,
                       Graph graph, int halvings) noexcept nogil

cdef void spread(Patch patch, Graph graph, int halvings) noexcept nogil

cdef long long build_from_kinds(Picture picture, Sample sample, Patch patch, Graph graph,
                                int halvings) noexcept nogil

cdef void follow(Picture picture, Sample sample, Patch patch) noexcept nogil
