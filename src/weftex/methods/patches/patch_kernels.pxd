cimport cython

cdef enum:  # how the candidates for a patch are found
    ALL = 0  # they are all windows
    SQUARES = 1  # they are the nearest in the low resolution (Liang et al., section 3.2)
    COMPONENTS = 2  # or in its principal components (section 3.3)
    TREE = 3  # or those that a kd-tree finds (section 3.1): it has listed them

@cython.final
cdef class Tolerance:
    cdef double value
    cdef bint of_best  # relative to the best match; else to the zone's root mean square
    cdef bint by_similarity  # more similar windows are drawn more often
    cdef bint accepts_all

    cdef double limit(self, long long energy, double best) noexcept nogil
    cdef bint matches(self, double distance, double limit) noexcept nogil

cdef class Patches:
    cdef const unsigned char[:, :, ::1] pixels  # of the sample
    cdef const unsigned char[:, :, ::1] transposed  # the same with exchanged axes
    cdef int[:, ::1] placements  # (n, 5), as in `Layout`; sources are filled in
    cdef unsigned short[:, ::1] cuts  # as in `Layout`; filled in
    cdef const unsigned long long[::1] bits  # (n,), random
    cdef const int[:, ::1] around  # (n, k): earlier patches not to repeat; -1 for none
    cdef Py_ssize_t keep_apart  # pixels between the sources of patches around

cdef class WindowSearch:
    cdef int finder
    cdef Py_ssize_t stride
    cdef const unsigned char[:, ::1] usable
    cdef const int[::1] corners
    cdef Py_ssize_t area, side  # these and the next ones: of `BoundaryZone`
    cdef const int[:, ::1] strips, squares
    cdef const int[::1] bands
    cdef const unsigned char[:, :, :, :, ::1] nodes
    cdef const short[:, ::1] basis, coordinates  # these and the next ones: of `Components`
    cdef const int[::1] offset
    cdef int shift

cdef class Shortlist:
    cdef Py_ssize_t wanted  # candidates: m of Liang et al., section 3.2
    cdef int[::1] corners  # of the candidates in the sample, as row * width + column
    cdef long long[::1] distances  # squared, of the zones; above a bound, partial sums
    cdef unsigned char[::1] marks  # why a candidate may not be drawn; 0 if it may
    cdef unsigned char[::1] zone  # the pixels of the output in the zone
    cdef int[::1] means  # of its squares
    cdef short[::1] coordinates  # in principal components
    cdef long long[:, ::1] path  # scratch of `cut_bands`

cdef Py_ssize_t choose_window(const unsigned char[:, :, ::1] canvas, Patches patches, Py_ssize_t p,
                              WindowSearch search, Tolerance tolerance,
                              Shortlist shortlist) noexcept nogil

cdef Py_ssize_t find_similar(const unsigned char[:, :, ::1] canvas, Patches patches, Py_ssize_t p,
                             WindowSearch search, Tolerance tolerance, long long energy,
                             Shortlist shortlist) noexcept nogil

cdef Py_ssize_t list_candidates(const unsigned char[:, :, ::1] canvas, Py_ssize_t y, Py_ssize_t x,
                                WindowSearch search, Shortlist shortlist) noexcept nogil

cpdef long long copy_zone(const unsigned char[:, :, ::1] canvas, Py_ssize_t y, Py_ssize_t x,
                          const int[:, ::1] strips, unsigned char[::1] zone) noexcept nogil

cpdef long long zone_distance(const unsigned char[:, :, ::1] pixels,
                              const unsigned char[:, :, ::1] transposed,
                              Py_ssize_t y, Py_ssize_t x, const int[:, ::1] strips,
                              const unsigned char[::1] zone, long long bound) noexcept nogil

cdef void compare(Patches patches, Py_ssize_t p, WindowSearch search, Tolerance tolerance,
                  long long energy, Py_ssize_t count, Shortlist shortlist) noexcept nogil

cdef Py_ssize_t compare_skipped(Patches patches, Py_ssize_t p, WindowSearch search,
                                Py_ssize_t count, Shortlist shortlist) noexcept nogil

cdef Py_ssize_t list_everywhere(WindowSearch search, Py_ssize_t start,
                                Shortlist shortlist) noexcept nogil

cdef unsigned char mark_of(Patches patches, Py_ssize_t p, Py_ssize_t y, Py_ssize_t x) noexcept nogil

cdef Py_ssize_t free_repeats(Py_ssize_t count, Shortlist shortlist) noexcept nogil

cdef Py_ssize_t draw_one(Py_ssize_t best, Py_ssize_t count, long long energy,
                         unsigned long long bits, Tolerance tolerance,
                         Shortlist shortlist) noexcept nogil
