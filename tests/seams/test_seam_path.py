"""Minimum-error paths keep to where a patch shows; see `brute_force` for their errors."""

import numpy as np

from weftex.methods.patches import cut_kernels as _kernels
from weftex.methods.patches.boundary_zone import boundary_zone
from weftex.results.paste_kernels import Layout


def find_cuts(canvas, pixels, place, weight, bands, row, cost, cuts):
    """Cut a patch at (y, x, source y, source x); fill its row of `cuts`."""
    placements = np.zeros((row + 1, 5), np.int32)
    placements[row, :4] = place
    layout = Layout(placements, weight[None], cuts, *canvas.shape[:2])
    _kernels.cut_bands(canvas, pixels, layout, bands, row, cost, cuts)


def kernel_cuts(canvas, pixels, corner, source, zone):
    rows, columns = zone.weight.shape
    cuts = np.full((2, 2 * (rows + columns)), 9999, np.uint16)
    cost = np.empty((max(rows, columns), int(zone.bands[0])), np.int64)
    assert zone.bands.dtype == np.int32 and zone.bands.shape == (9,)
    find_cuts(canvas, pixels, (*corner, *source), zone.weight, zone.bands, 1, cost, cuts)
    assert (cuts[0] == 9999).all()  # only its own row
    return cuts[1]


def test_paths_keep_to_where_the_patch_shows():
    """A step that shows nothing costs more than any that does, however long and bright."""
    known = np.zeros((9, 9), bool)
    known[:, :6] = True
    zone = boundary_zone(known, 3)
    assert zone.bands.tolist() == [3, 3, 9, 0, 9, 1, 0, 0, 0]
    frozen = np.zeros((9, 9), bool)
    frozen[:, 3] = True
    frozen[4, 3:5] = True  # a step aside
    zone = boundary_zone(known, 3, frozen=frozen)
    black, white = np.zeros((9, 9, 1), np.uint8), np.full((9, 9, 1), 255, np.uint8)
    cut = kernel_cuts(black, white, (0, 0), (0, 0), zone)
    assert all(zone.weight[v, cut[v]] > 0 for v in range(9))


def test_costs_of_long_bands_do_not_overflow():
    length = 40000
    known = np.zeros((length, 2), bool)
    known[:, :1] = True
    zone = boundary_zone(known, 1)
    canvas, pixels = np.zeros((length, 2, 1), np.uint8), np.full((length, 2, 1), 255, np.uint8)
    bands = zone.bands.copy()
    bands[5:] = 1, 0, 0, 0
    cost = np.empty((length, 1), np.int64)
    cuts = np.zeros((1, 2 * (length + 2)), np.uint16)
    find_cuts(canvas, pixels, (0, 0, 0, 0), zone.weight, bands, 0, cost, cuts)
    assert cost[-1, 0] == length * 255**2 > 2**31
