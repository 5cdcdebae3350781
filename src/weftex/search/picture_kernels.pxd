cdef class SampleWindows:
    cdef const unsigned char[:, :, ::1] pixels
    cdef const unsigned char[:, ::1] usable
    cdef const int[::1] period

cdef class Picture:
    cdef unsigned char[:, :, ::1] pixels
    cdef unsigned char[:, ::1] done
    cdef int[:, ::1] source
    cdef bint wrap_y, wrap_x

cdef class Query:
    cdef int[:, ::1] runs  # (dy, dx, length), seen from the pixel
    cdef Py_ssize_t count  # of the runs
    cdef unsigned char[::1] values  # their bytes, run after run

# Here, or they cannot be inlined.
cdef inline Py_ssize_t around(Py_ssize_t at, Py_ssize_t n) noexcept nogil:
    """A row or column less than n beyond the border of n, around it."""
    return at + n if at < 0 else at - n if at >= n else at

cdef inline Py_ssize_t portion(unsigned long long bits, Py_ssize_t count) noexcept nogil:
    """A number below `count`, from the upper half of 64 random bits."""
    return (bits >> 32) * <unsigned long long> count >> 32

cpdef Py_ssize_t known_runs(const unsigned char[:, ::1] done, Py_ssize_t y, Py_ssize_t x,
                           bint wrap_y, bint wrap_x, Py_ssize_t reach,
                           int[:, ::1] runs) noexcept nogil

cpdef Py_ssize_t usable_place(const unsigned char[:, ::1] usable, const int[::1] period,
                             Py_ssize_t y, Py_ssize_t x) noexcept nogil

cdef Py_ssize_t coherent_places(Picture picture, SampleWindows sample, Py_ssize_t y, Py_ssize_t x,
                                Query query, int[::1] places, Py_ssize_t count) noexcept nogil
