cdef void cut_bands(const unsigned char[:, :, ::1] canvas, const unsigned char[:, :, ::1] pixels,
                    Py_ssize_t y, Py_ssize_t x, Py_ssize_t sy, Py_ssize_t sx,
                    const unsigned short[:, :, ::1] weights, const int[::1] bands,
                    long long[:, ::1] cost, unsigned short[:, ::1] cuts, Py_ssize_t p) noexcept nogil
