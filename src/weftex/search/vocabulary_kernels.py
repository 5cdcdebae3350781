# mypy: ignore-errors
"""What kernels that compare windows work on; compiled by Cython, see setup.py and the .pxd."""

import cython  # noqa: F401


class Sample:
    """The windows of a sample, see `weftex.search.windows.Windows`."""

    def __init__(self, pixels, usable, period):
        self.pixels, self.usable, self.period = pixels, usable, period


class Picture:
    """The picture while it is made.

    `done` is 1 where a pixel is known or made, `source` its flat index into the sample's pixels or
    -1, `wrap` whether the vertical and the horizontal axis wrap.
    """

    def __init__(self, pixels, done, source, wrap):
        self.pixels, self.done, self.source = pixels, done, source
        self.wrap_y, self.wrap_x = wrap


class Query:
    """Room for the known part of the window around a pixel."""

    def __init__(self, runs, values):
        self.runs, self.values, self.count = runs, values, 0
