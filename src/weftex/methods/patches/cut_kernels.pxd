from weftex.results.paste_kernels cimport Layout

cpdef void cut_bands(const unsigned char[:, :, ::1] canvas, const unsigned char[:, :, ::1] pixels,
                     Layout layout, const int[::1] bands, Py_ssize_t p,
                     long long[:, ::1] cost, unsigned short[:, ::1] cuts) noexcept nogil

cdef void add_up(const unsigned char[:, :, ::1] canvas, const unsigned char[:, :, ::1] pixels,
                 Layout layout, const int[::1] bands, Py_ssize_t p, Py_ssize_t side,
                 long long[:, ::1] cost) noexcept nogil

cdef void trace_back(const long long[:, ::1] cost, Py_ssize_t length, Py_ssize_t depth,
                     Py_ssize_t edge, Py_ssize_t inward, unsigned short* cut) noexcept nogil
