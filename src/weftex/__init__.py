"""weftex: example-based texture synthesis.

Further functions lie in modules: `prepare` straightens, lights, turns and joins samples;
`label_maps` has gradients for `fuse`; `pages` makes HTML reports; `planes` writes images larger
than memory; `reference` has the papers' algorithms as short NumPy functions.

>>> import numpy as np, weftex
>>> sample = np.random.default_rng(0).integers(0, 255, (64, 64, 3), np.uint8)
>>> weftex.synthesize(sample, (96, 128), method="quilting", seed=7).image.shape
(96, 128, 3)
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from weftex.dispatch import prefer_fast_kernels

if TYPE_CHECKING:
    from weftex import label_maps as label_maps
    from weftex import pages as pages
    from weftex import planes as planes
    from weftex import prepare as prepare
    from weftex import reference as reference
    from weftex.canvas import Canvas as Canvas
    from weftex.errors import CancelledError as CancelledError
    from weftex.errors import FileError as FileError
    from weftex.errors import InvalidInputError as InvalidInputError
    from weftex.errors import UnsupportedError as UnsupportedError
    from weftex.errors import WeftexError as WeftexError
    from weftex.exemplar import Exemplar as Exemplar
    from weftex.exemplar import load_exemplar as load_exemplar
    from weftex.io.pictures import read_image as read_image
    from weftex.io.pictures import write_image as write_image
    from weftex.method import Method as Method
    from weftex.methods.ashikhmin import Ashikhmin as Ashikhmin
    from weftex.methods.best_tile import BestTile as BestTile
    from weftex.methods.efros_leung import EfrosLeung as EfrosLeung
    from weftex.methods.exact_matching import ExactMatching as ExactMatching
    from weftex.methods.graphcut import GraphCut as GraphCut
    from weftex.methods.near_regular import NearRegular as NearRegular
    from weftex.methods.patch_sampling import PatchSampling as PatchSampling
    from weftex.methods.quilting import Quilting as Quilting
    from weftex.methods.refinement import Refinement as Refinement
    from weftex.methods.wei_levoy import WeiLevoy as WeiLevoy
    from weftex.quality.assess import Assessment as Assessment
    from weftex.quality.assess import assess as assess
    from weftex.registry import METHODS as METHODS
    from weftex.results.synthesis import Synthesis as Synthesis
    from weftex.tasks.analyze import analyze as analyze
    from weftex.tasks.auto import Auto as Auto
    from weftex.tasks.fill import fill as fill
    from weftex.tasks.fuse import fuse as fuse
    from weftex.tasks.synthesize import synthesize as synthesize
    from weftex.tasks.tile import tile as tile

__version__ = "0.2.0"

prefer_fast_kernels()

#: Public names by their modules; each is imported when it is asked for.
_PUBLIC = {
    "canvas": ["Canvas"],
    "errors": [
        "CancelledError",
        "FileError",
        "InvalidInputError",
        "UnsupportedError",
        "WeftexError",
    ],
    "exemplar": ["Exemplar", "load_exemplar"],
    "io.pictures": ["read_image", "write_image"],
    "method": ["Method"],
    "methods.ashikhmin": ["Ashikhmin"],
    "methods.best_tile": ["BestTile"],
    "methods.efros_leung": ["EfrosLeung"],
    "methods.exact_matching": ["ExactMatching"],
    "methods.graphcut": ["GraphCut"],
    "methods.near_regular": ["NearRegular"],
    "methods.patch_sampling": ["PatchSampling"],
    "methods.quilting": ["Quilting"],
    "methods.refinement": ["Refinement"],
    "methods.wei_levoy": ["WeiLevoy"],
    "quality.assess": ["Assessment", "assess"],
    "results.synthesis": ["Synthesis"],
    "registry": ["METHODS"],
    "tasks.analyze": ["analyze"],
    "tasks.auto": ["Auto"],
    "tasks.fill": ["fill"],
    "tasks.fuse": ["fuse"],
    "tasks.synthesize": ["synthesize"],
    "tasks.tile": ["tile"],
}
_HOME = {name: module for module, names in _PUBLIC.items() for name in names}
#: Public modules; the names of each are its `__all__`.
_MODULES = ["atlas", "label_maps", "pages", "planes", "prepare", "reference"]

__all__ = sorted(_HOME)


def __getattr__(name: str) -> Any:
    from importlib import import_module

    if name in _MODULES:
        return import_module(f"weftex.{name}")
    if name not in _HOME:
        raise AttributeError(f"module 'weftex' has no attribute '{name}'")
    value = getattr(import_module("weftex." + _HOME[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__, *_MODULES})
