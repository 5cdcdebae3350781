cpdef long long copy_zone(const unsigned char[:, :, ::1] canvas, Py_ssize_t y, Py_ssize_t x,
                      const int[:, ::1] runs, unsigned char[::1] query) noexcept nogil

cpdef long long zone_distance(const unsigned char[:, :, ::1] pixels, const unsigned char[:, :, ::1] transposed,
                        Py_ssize_t y, Py_ssize_t x, const int[:, ::1] runs,
                        const unsigned char[::1] query, long long bound) noexcept nogil

cpdef void block_means(const unsigned char[:, :, ::1] canvas, Py_ssize_t y, Py_ssize_t x,
                      const int[:, ::1] blocks, Py_ssize_t side, int[::1] means) noexcept nogil

cdef class Shortlist:
    cdef Py_ssize_t wanted  # m of section 3.2
    cdef long long[::1] keys  # squared distances; above a bound, partial sums
    cdef int[::1] places  # windows of the sample, by row * width + column of their corner
    cdef unsigned char[::1] query  # the zone's pixels
    cdef int[::1] means  # of its blocks
    cdef short[::1] coordinates  # in principal components
    cdef int[::1] partial  # scratch of `nearest_by_blocks`, a row of windows each
    cdef long long[::1] total
    cdef unsigned char[::1] excluded  # why a candidate may not be taken; 0 if it may
    cdef long long[:, ::1] path  # scratch of `cut_bands`

cpdef Py_ssize_t nearest_by_blocks(const unsigned char[:, :, :, :, ::1] nodes,
                                  const int[:, ::1] blocks, const int[::1] query,
                                  const unsigned char[:, ::1] usable,
                                  Shortlist shortlist) noexcept nogil

cpdef void project(const short[:, ::1] basis, const int[::1] offset, int shift,
                  const int[::1] means, short[::1] features) noexcept nogil

cdef void distances_by_features(const short[:, ::1] features, const short[::1] query,
                                int[::1] out) noexcept nogil

cpdef Py_ssize_t nearest_by_features(const short[:, ::1] features, const int[::1] at,
                                    const short[::1] query, Py_ssize_t wanted,
                                    long long[::1] keys, int[::1] places) noexcept nogil

cdef Py_ssize_t offer(long long key, int place, Py_ssize_t count, Py_ssize_t wanted,
                      long long* keys, int* places) noexcept nogil

cdef enum:  # where candidates come from
    ALL = 0  # all windows
    BLOCKS = 1  # the nearest in the low resolution (section 3.2)
    COMPONENTS = 2  # the nearest in its principal components (section 3.3)
    TREE = 3  # a kd-tree (section 3.1), which has listed them

cdef class ZoneWindows:
    cdef int source
    cdef const unsigned char[:, ::1] usable
    cdef const int[::1] positions
    cdef Py_ssize_t area
    cdef const int[:, ::1] runs
    cdef const int[:, ::1] blocks
    cdef Py_ssize_t side
    cdef const int[::1] bands
    cdef const unsigned char[:, :, :, :, ::1] nodes
    cdef const short[:, ::1] basis
    cdef const int[::1] offset
    cdef int shift
    cdef const short[:, ::1] features

cdef Py_ssize_t list_candidates(const unsigned char[:, :, ::1] canvas, Py_ssize_t y, Py_ssize_t x,
                                ZoneWindows windows, Shortlist found) noexcept nogil

cdef Py_ssize_t climb(const unsigned char[:, :, ::1] pixels, const unsigned char[:, :, ::1] transposed,
                      ZoneWindows windows, Py_ssize_t count, Shortlist found) noexcept nogil
