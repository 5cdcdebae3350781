from weftex.methods.graphcut.graph_kernels cimport Graph, Patch
from weftex.methods.graphcut.seam_kernels cimport Picture, Sample

cdef Py_ssize_t run_end(Picture picture, Patch patch, Graph graph, Py_ssize_t v, Py_ssize_t u,
                        int halvings) noexcept nogil

cdef bint add_run(Picture picture, Sample sample, Patch patch, Graph graph, Py_ssize_t v,
                  Py_ssize_t first, Py_ssize_t end, int halvings) noexcept nogil
