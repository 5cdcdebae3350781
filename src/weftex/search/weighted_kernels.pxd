cdef class Sample:
    cdef const unsigned char[::1] flat  # the pixels row by row, and a stride more
    cdef const unsigned char[:, ::1] usable
    cdef const int[::1] period
    cdef const short[:, ::1] weights
    cdef Py_ssize_t stride  # bytes of a row of a query
    cdef Py_ssize_t width, channels, reach

cdef class Picture:
    cdef const unsigned char[:, :, ::1] pixels
    cdef const unsigned char[:, ::1] done
    cdef const int[:, ::1] source
    cdef bint wrap_y, wrap_x

cdef class Query:
    cdef int[:, ::1] runs
    cdef unsigned char[::1] values  # a row of the window is a stride
    cdef short[::1] weights  # of each value; 0 where nothing is known
    cdef int[::1] rows  # their number, then the rows with anything known, the nearest first

cdef class Found:
    cdef int[::1] places  # flat indices into the sample; -1 for no window
    cdef long long[::1] distances

cdef class Choices:
    cdef const int[::1] places  # flat indices into the picture
    cdef const unsigned long long[::1] bits
    cdef double tolerance
    cdef int[::1] chosen  # flat indices into the sample
    cdef long long[::1] distances
    cdef long long[::1] weights  # of what is known

cdef long long look(Picture picture, Sample sample, Py_ssize_t y, Py_ssize_t x,
                    Query query) noexcept nogil

cdef Py_ssize_t coherent_windows(Picture picture, Sample sample, Py_ssize_t y, Py_ssize_t x,
                                 Query query, Found found, Py_ssize_t count) noexcept nogil

cdef long long window_distance(Sample sample, Py_ssize_t place, Query query,
                               long long bound) noexcept nogil

cdef long long limit_of(long long best, double tolerance) noexcept nogil

cdef void choose_one(Choices choices, Py_ssize_t i, Found found, Py_ssize_t count,
                     long long limit) noexcept nogil
