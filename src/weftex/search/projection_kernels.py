# mypy: ignore-errors
"""Kernel that projects a window of the canvas on components; compiled by Cython, see setup.py."""

import cython


class Components:
    """A `WindowComponents` for kernels, and room for what `run_coordinates` computes.

    Declared in the .pxd; `coordinates` is where `run_coordinates` leaves its result. The arrays of
    the room have the length of a row of the basis (`difference`), else one number a component.
    """

    def __init__(self, found, difference, totals, coordinates):
        self.mean, self.basis, self.mean_product = found.mean, found.basis, found.mean_product
        self.offset, self.shift, self.features = found.offset, found.shift, found.features
        self.difference, self.totals, self.coordinates = difference, totals, coordinates


def run_coordinates(components, runs, count, query):
    """Coordinates of a window of which the runs are known, rounded as `WindowComponents` does.

    The rest is taken to differ from the mean color, along each component, as what is known.
    """
    cython.declare(row=cython.p_const_short, total=cython.int)
    cython.declare(value=cython.longlong, rise=cython.longlong)
    cython.declare(r=cython.Py_ssize_t, d=cython.Py_ssize_t, i=cython.Py_ssize_t)
    cython.declare(k=cython.Py_ssize_t, length=cython.Py_ssize_t)
    channels: cython.Py_ssize_t = components.mean.shape[0]
    reach: cython.Py_ssize_t = (components.basis.shape[0] - 1) // 2
    whole: cython.Py_ssize_t = (
        components.basis.shape[0] * components.basis.shape[0] * channels - channels
    )
    at: cython.Py_ssize_t = 0
    for d in range(components.totals.shape[0]):
        components.totals[d] = 0
    for r in range(count):
        length = runs[r, 2] * channels
        k = 0
        for i in range(length):
            components.difference[i] = cython.cast(
                cython.short, cython.cast(cython.short, query[at + i]) - components.mean[k]
            )
            k = k + 1 if k + 1 < channels else 0
        for d in range(components.totals.shape[0]):
            row = cython.address(
                components.basis[runs[r, 0] + reach, d, (runs[r, 1] + reach) * channels]
            )
            total = 0
            for i in range(length):  # components are 2000 long, so no sum passes 2**31
                total += cython.cast(cython.int, row[i]) * components.difference[i]
            components.totals[d] += total
        at += length
    rise = whole * 256 // at if at else 0
    for d in range(components.totals.shape[0]):
        value = (
            ((components.totals[d] * rise + 128) >> 8)
            + components.mean_product[d]
            - components.offset[d]
        )
        value = (value + ((1 << components.shift) >> 1)) >> components.shift
        components.coordinates[d] = cython.cast(
            cython.short, -4095 if value < -4095 else 4095 if value > 4095 else value
        )


def coordinates_of_runs(components: Components, runs, query):
    """`run_coordinates` from Python; the coordinates, as the components have them."""
    run_coordinates(components, runs, len(runs), query)
    return components.coordinates
