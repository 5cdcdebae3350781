# Nothing is taken from here by other kernels.
