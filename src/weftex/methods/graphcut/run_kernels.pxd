from weftex.methods.graphcut.graph_kernels cimport Patch
from weftex.methods.graphcut.seam_kernels cimport Picture, Sample

cdef void follow(Picture picture, Sample sample, Patch patch, int[:, ::1] ends) noexcept nogil
