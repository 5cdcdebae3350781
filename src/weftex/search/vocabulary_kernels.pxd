cdef class Sample:
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
