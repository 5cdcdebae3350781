from weftex.results.paste_kernels cimport value

cdef inline double difference(value one, value other) noexcept nogil
cdef double led(const value[:, :, ::1] sample, const int[:, :, :, ::1] coordinates,
                const float[:, :, ::1] shares, const unsigned short[:, :] part, Py_ssize_t v, Py_ssize_t u,
                int axis, int way, double* slope) noexcept nogil
