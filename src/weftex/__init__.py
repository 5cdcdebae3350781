"""weftex: example-based texture synthesis.

>>> import numpy as np, weftex
>>> sample = np.random.default_rng(0).integers(0, 255, (64, 64, 3), np.uint8)
>>> weftex.synthesize(sample, (96, 128), method="quilting", seed=7).image.shape
(96, 128, 3)
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from weftex.dispatch import prefer_fast_kernels

if TYPE_CHECKING:
    from weftex import reference as reference
    from weftex.canvas import Canvas as Canvas
    from weftex.errors import CancelledError as CancelledError
    from weftex.errors import FileError as FileError
    from weftex.errors import InvalidInputError as InvalidInputError
    from weftex.errors import UnsupportedError as UnsupportedError
    from weftex.errors import WeftexError as WeftexError
    from weftex.exemplar import Exemplar as Exemplar
    from weftex.explanation import Explanation as Explanation
    from weftex.explanation import explain as explain
    from weftex.io.pictures import read_image as read_image
    from weftex.io.pictures import write_image as write_image
    from weftex.loading import load_exemplar as load_exemplar
    from weftex.method import Method as Method
    from weftex.methods import METHODS as METHODS
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
    from weftex.pages import Report as Report
    from weftex.pages import compare as compare
    from weftex.pages import report as report
    from weftex.planes import plane as plane
    from weftex.planes import stream as stream
    from weftex.quality.assess import Assessment as Assessment
    from weftex.quality.assess import assess as assess
    from weftex.results.synthesis import Synthesis as Synthesis
    from weftex.studio.notebook import view as view
    from weftex.tasks.analyze import analyze as analyze
    from weftex.tasks.auto import Auto as Auto
    from weftex.tasks.combined import together as together
    from weftex.tasks.estimate_maps import estimate_maps as estimate_maps
    from weftex.tasks.even_light import even_light as even_light
    from weftex.tasks.fill import fill as fill
    from weftex.tasks.fuse import fuse as fuse
    from weftex.tasks.gradient import Gradient as Gradient
    from weftex.tasks.straighten import straighten as straighten
    from weftex.tasks.synthesize import synthesize as synthesize
    from weftex.tasks.tile import tile as tile
    from weftex.turns import turned as turned

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
    "exemplar": ["Exemplar"],
    "explanation": ["Explanation", "explain"],
    "io.pictures": ["read_image", "write_image"],
    "loading": ["load_exemplar"],
    "method": ["Method"],
    "methods": ["METHODS"],
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
    "pages": ["Report", "compare", "report"],
    "planes": ["plane", "stream"],
    "quality.assess": ["Assessment", "assess"],
    "results.synthesis": ["Synthesis"],
    "studio.notebook": ["view"],
    "tasks.analyze": ["analyze"],
    "tasks.auto": ["Auto"],
    "tasks.combined": ["together"],
    "tasks.estimate_maps": ["estimate_maps"],
    "tasks.even_light": ["even_light"],
    "tasks.fill": ["fill"],
    "tasks.fuse": ["fuse"],
    "tasks.gradient": ["Gradient"],
    "tasks.straighten": ["straighten"],
    "tasks.synthesize": ["synthesize"],
    "tasks.tile": ["tile"],
    "turns": ["turned"],
}
_HOME = {name: module for module, names in _PUBLIC.items() for name in names}

__all__ = sorted(_HOME)


def __getattr__(name: str) -> Any:
    from importlib import import_module

    if name == "reference":
        return import_module("weftex.reference")
    if name not in _HOME:
        raise AttributeError(f"module 'weftex' has no attribute '{name}'")
    value = getattr(import_module("weftex." + _HOME[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__, "reference"})
