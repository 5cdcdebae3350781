cdef Py_ssize_t near_colors(const unsigned char[:, ::1] colors, const unsigned char[:, ::1] low,
                            const unsigned char[:, ::1] high, Py_ssize_t depth, Py_ssize_t number,
                            long long radius, int[:, ::1] intervals,
                            Py_ssize_t row) noexcept nogil
