"""weft: example-based texture synthesis.

>>> import numpy as np, weft
>>> sample = np.random.default_rng(0).integers(0, 255, (64, 64, 3), np.uint8)
>>> weft.synthesize(sample, (96, 128), method="quilting", seed=7).image.shape
(96, 128, 3)
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from weft.canvas import Canvas
    from weft.errors import (
        CancelledError,
        FileError,
        InvalidInputError,
        UnsupportedError,
        WeftError,
    )
    from weft.exemplar import Exemplar
    from weft.io import read_image, write_image
    from weft.method import METHODS, Method
    from weft.methods.ashikhmin import Ashikhmin
    from weft.methods.auto import Auto
    from weft.methods.best_tile import BestTile
    from weft.methods.efros_leung import EfrosLeung
    from weft.methods.exact_matching import ExactMatching
    from weft.methods.graphcut import GraphCut
    from weft.methods.near_regular import NearRegular
    from weft.methods.patch_sampling import PatchSampling
    from weft.methods.quilting import Quilting
    from weft.methods.refinement import Refinement
    from weft.methods.wei_levoy import WeiLevoy
    from weft.quality.assess import Assessment, assess
    from weft.synthesis import Synthesis
    from weft.tasks.analyze import analyze
    from weft.tasks.compare import compare
    from weft.tasks.fill import fill
    from weft.tasks.fuse import fuse
    from weft.tasks.report import Report, report
    from weft.tasks.synthesize import load_exemplar, synthesize

__version__ = "0.1.0"

_HOME = {
    "METHODS": "method",
    "Ashikhmin": "methods.ashikhmin",
    "Assessment": "quality.assess",
    "Auto": "methods.auto",
    "BestTile": "methods.best_tile",
    "Canvas": "canvas",
    "CancelledError": "errors",
    "EfrosLeung": "methods.efros_leung",
    "ExactMatching": "methods.exact_matching",
    "Exemplar": "exemplar",
    "FileError": "errors",
    "GraphCut": "methods.graphcut",
    "InvalidInputError": "errors",
    "Method": "method",
    "NearRegular": "methods.near_regular",
    "PatchSampling": "methods.patch_sampling",
    "Quilting": "methods.quilting",
    "Refinement": "methods.refinement",
    "Report": "tasks.report",
    "Synthesis": "synthesis",
    "UnsupportedError": "errors",
    "WeftError": "errors",
    "WeiLevoy": "methods.wei_levoy",
    "analyze": "tasks.analyze",
    "assess": "quality.assess",
    "compare": "tasks.compare",
    "fill": "tasks.fill",
    "fuse": "tasks.fuse",
    "load_exemplar": "tasks.synthesize",
    "read_image": "io",
    "report": "tasks.report",
    "synthesize": "tasks.synthesize",
    "write_image": "io",
}

__all__ = [
    "METHODS",
    "Ashikhmin",
    "Assessment",
    "Auto",
    "BestTile",
    "CancelledError",
    "Canvas",
    "EfrosLeung",
    "ExactMatching",
    "Exemplar",
    "FileError",
    "GraphCut",
    "InvalidInputError",
    "Method",
    "NearRegular",
    "PatchSampling",
    "Quilting",
    "Refinement",
    "Report",
    "Synthesis",
    "UnsupportedError",
    "WeftError",
    "WeiLevoy",
    "analyze",
    "assess",
    "compare",
    "fill",
    "fuse",
    "load_exemplar",
    "read_image",
    "report",
    "synthesize",
    "write_image",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'weft' has no attribute '{name}'")
    from importlib import import_module

    value = getattr(import_module("weft." + _HOME[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
