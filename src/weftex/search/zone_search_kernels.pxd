from weftex.search.zone_kernels cimport Shortlist

cdef enum:
    ALL = 0
    BLOCKS = 1
    FEATURES = 2
    GIVEN = 3

cdef class Sample:
    cdef const unsigned char[:, :, ::1] pixels
    cdef const unsigned char[:, :, ::1] turned

cdef class Zone:
    cdef Py_ssize_t area
    cdef const int[:, ::1] runs
    cdef const int[:, ::1] blocks
    cdef Py_ssize_t side
    cdef const int[::1] bands

cdef class Search:
    cdef int source
    cdef Py_ssize_t wanted
    cdef const unsigned char[:, ::1] usable
    cdef const int[::1] positions
    cdef const unsigned char[:, :, :, :, ::1] nodes
    cdef const short[:, ::1] basis
    cdef const int[::1] offset
    cdef int shift
    cdef const short[:, ::1] features

cdef class Candidates(Shortlist):
    cdef unsigned char[::1] query
    cdef int[::1] means
    cdef short[::1] coordinates

cdef Py_ssize_t list_candidates(const unsigned char[:, :, ::1] canvas, Py_ssize_t y, Py_ssize_t x,
                                Zone zone, Search search, const int[::1] given,
                                Candidates found) noexcept nogil

cdef Py_ssize_t climb(Sample sample, Zone zone, Search search, Py_ssize_t count,
                      Candidates found) noexcept nogil
