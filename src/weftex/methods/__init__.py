"""How to choose the pixels: one package a method, named after its slug.

Patch-based sampling and quilting are a module each, over the shared package `patches`.

Examples
--------
>>> make_method("quilting", {"patch_size": 24}).patch_size
24
"""

from __future__ import annotations

import dataclasses

from weftex.naming import make_method
from weftex.registry import METHODS

__all__ = ["METHODS", "make_method", "owners"]

METHODS.declare(
    {
        "patch-sampling": "weftex.methods.patch_sampling:PatchSampling",
        "quilting": "weftex.methods.quilting:Quilting",
        "graphcut": "weftex.methods.graphcut:GraphCut",
        "efros-leung": "weftex.methods.efros_leung:EfrosLeung",
        "wei-levoy": "weftex.methods.wei_levoy:WeiLevoy",
        "ashikhmin": "weftex.methods.ashikhmin:Ashikhmin",
        "exact-matching": "weftex.methods.exact_matching:ExactMatching",
        "refinement": "weftex.methods.refinement:Refinement",
        "best-tile": "weftex.methods.best_tile:BestTile",
        "near-regular": "weftex.methods.near_regular:NearRegular",
    }
)


def owners(parameter: str) -> list[str]:
    """The methods that have a parameter of this name."""
    return [s for s in METHODS if parameter in (f.name for f in dataclasses.fields(METHODS[s]))]
