"""Each paper's algorithm as one readable NumPy function: from the paper, and nothing else.

The references are for reading, and tests compare the methods with them. They are slow: they compare
all windows with all windows, have the paper's parameters only, and suit pictures of up to some two
hundred pixels a side. `weftex.METHODS` has the same algorithms made fast, with what papers lack.

Every function takes and returns plain arrays, as a `Made`: the picture and where it comes from.
The pages in docs/background/fidelity list each step of the papers with its place in the methods.
"""

from __future__ import annotations

from weftex.reference.ashikhmin import ashikhmin
from weftex.reference.best_tile import best_tile
from weftex.reference.common import Made
from weftex.reference.efros_leung import efros_leung
from weftex.reference.exact_matching import exact_matching
from weftex.reference.fusion import fusion
from weftex.reference.graphcut import graphcut
from weftex.reference.heeger_bergen import heeger_bergen
from weftex.reference.image_quilting import image_quilting
from weftex.reference.iterative_refinement import iterative_refinement
from weftex.reference.lattice import Found, lattice
from weftex.reference.near_regular import near_regular
from weftex.reference.patch_based_sampling import patch_based_sampling
from weftex.reference.wei_levoy import wei_levoy

__all__ = [
    "Found",
    "Made",
    "ashikhmin",
    "best_tile",
    "efros_leung",
    "exact_matching",
    "fusion",
    "graphcut",
    "heeger_bergen",
    "image_quilting",
    "iterative_refinement",
    "lattice",
    "near_regular",
    "patch_based_sampling",
    "wei_levoy",
]
