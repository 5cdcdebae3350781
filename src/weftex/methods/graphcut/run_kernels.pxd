from weftex.methods.graphcut.seam_kernels cimport Labeling, SeamCost

cdef void update_runs(Labeling labeling, SeamCost sample, const int[::1] rows,
                      const int[::1] columns, const int[:, ::1] ends) noexcept nogil
