from weftex.results.paste_kernels cimport Layout

cdef void cut_bands(const unsigned char[:, :, ::1] canvas, const unsigned char[:, :, ::1] pixels,
                    Layout layout, const int[::1] bands, Py_ssize_t p,
                    long long[:, ::1] cost, unsigned short[:, ::1] cuts) noexcept nogil
