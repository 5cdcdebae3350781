"""Results on disk: where pixels come from, but no pictures."""

from __future__ import annotations

import json
import os
from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.canvas import Canvas
from weftex.errors import FileError
from weftex.io.pictures import atomic
from weftex.results.patches import PatchSynthesis, RectifiedSynthesis
from weftex.results.pixels import PixelSynthesis
from weftex.results.warped import WarpedSynthesis

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.exemplar import Exemplar
    from weftex.results.synthesis import Synthesis

_FORMAT = 1
_WIDEST = 1 << 24  # px of a block; no sample is as large
#: The kinds of results, the arrays of each and their types.
_PATCHES: dict[str, type] = {"placements": np.int32, "weights": np.uint16, "cuts": np.uint16}
_RECTIFIED: dict[str, type] = {**_PATCHES, "lookup": np.int32}
_KINDS: dict[type[Synthesis], dict[str, type]] = {
    WarpedSynthesis: {**_RECTIFIED, "warps": np.int16, "within": np.int32},
    RectifiedSynthesis: _RECTIFIED,
    PatchSynthesis: _PATCHES,
    PixelSynthesis: {"index": np.int32},
}


class _Damage(ValueError):
    """What a file that weftex once wrote cannot contain."""


def write_result(path: str | os.PathLike[str], result: Synthesis) -> None:
    """Write a result to a compressed `.npz` file; nothing is left behind if that fails."""
    about = {
        "format": _FORMAT,
        "shape": result.shape,
        "wrap": result.canvas.wrap,
        "origin": result.canvas.origin,
        "sample_shape": result.sample_shape,
        "known_from": result.known_from,
        "provenance": result.provenance,
    }
    arrays = result.arrays()
    if result.canvas.hole is not None:
        arrays["hole"] = np.packbits(result.canvas.hole, axis=1)
    with atomic(path) as temporary, open(temporary, "wb") as file:
        np.savez_compressed(file, about=np.array(json.dumps(about)), **arrays)  # type: ignore[arg-type]


def read_result(
    path: str | os.PathLike[str], exemplar: Exemplar | None, known: NDArray[Any] | None
) -> Synthesis:
    """Return the result that was written.

    Raises
    ------
    FileError
        If the file is missing, damaged, or something else.
    """
    name = os.fsdecode(path)
    try:
        with open(path, "rb") as raw, np.load(raw, allow_pickle=False) as file:
            about = json.loads(str(file["about"]))
            kind = next(k for k, arrays in _KINDS.items() if arrays.keys() <= file.keys())
            arrays = {key: file[key] for key in _KINDS[kind]}
            hole = file.get("hole")
        if about["format"] != _FORMAT:
            raise _Damage(f"its format is {about['format']}, not {_FORMAT}")
        height, width = about["shape"]
        origin = tuple(about.get("origin", (0, 0)))  # not in files of the first version
        canvas = Canvas(height, width, tuple(about["wrap"]), origin=origin)
        if any(arrays[key].dtype != dtype for key, dtype in _KINDS[kind].items()):
            raise _Damage("its arrays have other types")
        _check_about(about, canvas, hole)
        if issubclass(kind, PatchSynthesis):
            _check_patches(canvas, tuple(about["sample_shape"]), **arrays)
        else:
            least = 0 if hole is None else -1  # only known pixels come from nowhere
            _check_pixels(canvas, tuple(about["sample_shape"]), least, **arrays)
    except FileNotFoundError:
        raise FileError(f"{name} does not exist") from None
    except _Damage as error:
        raise FileError(f"{name} is damaged: {error}") from None
    except Exception:  # numpy and zipfile raise many kinds, with advice that does not fit here
        raise FileError(f"{name} is not a saved weftex result") from None
    if hole is not None:
        hole = np.unpackbits(hole, axis=1, count=width).astype(bool)
        canvas = Canvas(height, width, canvas.wrap, known, hole)
    return kind(
        canvas,
        **arrays,
        sample_shape=tuple(about["sample_shape"]),
        known_from=tuple(about["known_from"]) if about["known_from"] else None,
        provenance=about["provenance"],
        exemplar=exemplar,
    )


def _check_about(about: dict[str, Any], canvas: Canvas, hole: NDArray[Any] | None) -> None:
    if hole is not None and hole.shape != (canvas.height, -(-canvas.width // 8)):
        raise _Damage("its hole does not fit its size")
    known_from = about["known_from"]
    if known_from is not None:
        ends = np.add(known_from, canvas.shape)
        if min(known_from) < 0 or (ends > about["sample_shape"]).any():
            raise _Damage("its known pixels lie outside the sample")


def _check_patches(
    canvas: Canvas,
    sample_shape: tuple[int, int],
    placements: NDArray[Any],
    weights: NDArray[Any],
    cuts: NDArray[Any],
    lookup: NDArray[Any] | None = None,
    warps: NDArray[Any] | None = None,
    within: NDArray[Any] | None = None,
) -> None:
    """Raise unless the kernels may trust these arrays."""
    if placements.shape[1:] != (5,) or weights.ndim != 3 or cuts.ndim != 2:
        raise _Damage("its arrays have other shapes")
    if (weights > 256).any():
        raise _Damage("its weights are above 256")
    if cuts.size and cuts.shape != (len(placements), 2 * sum(weights.shape[1:])):
        raise _Damage("its cuts do not fit its patches")
    below = (*canvas.shape, *sample_shape, len(weights))
    if len(placements) and ((placements < 0) | (placements >= np.array(below))).any():
        raise _Damage("its patches lie outside")
    if lookup is not None:
        if lookup.shape != sample_shape:
            raise _Damage("its moved pixels do not fit its sample")
        if ((lookup < 0) | (lookup >= lookup.size)).any():
            raise _Damage("its moved pixels lie outside")
    if warps is not None and within is not None:
        nodes = warps.shape[1:2] if warps.ndim == 4 else (0,)
        if nodes[0] < 2 or warps.shape[1:] != (*nodes, *nodes, 2):
            raise _Damage("its warps have another shape")
        if len(warps) > len(placements) or within.shape != (len(warps), 5):
            raise _Damage("its warps do not fit its patches")
        least = np.array([0, 0, 1, 1, 0])
        if ((within < least) | (within > _WIDEST)).any():
            raise _Damage("its warps lie outside")


def _check_pixels(
    canvas: Canvas, sample_shape: tuple[int, int], least: int, index: NDArray[Any]
) -> None:
    if index.shape != canvas.shape:
        raise _Damage("its sources do not fit its size")
    if ((index < least) | (index >= sample_shape[0] * sample_shape[1])).any():
        raise _Damage("its sources lie outside")
