cdef void run_coordinates(const int[:, ::1] runs, Py_ssize_t n, const unsigned char[::1] query,
                          const unsigned char[::1] mean, const short[:, :, ::1] basis,
                          const long long[::1] level, const int[::1] offset, int shift,
                          short[::1] difference, long long[::1] totals,
                          short[::1] features) noexcept nogil
