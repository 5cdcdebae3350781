"""Results on disk: arrays and a few facts in one compressed file, without pictures."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from weftex.canvas import MAX_PIXELS
from weftex.io.npz import MOST_FACTS, DamageError, open_npz, write_npz
from weftex.raster.turning import gap_of

_FORMAT = 1
MOST_REACH = 256.0  #: pixels in which steps of tone may be spread
_CELLS = 8, 2**11  # sides of the sample, and pixels, by which cells may exceed a part of a plane
_MOST_BYTES = 64  # a pixel of output and sample: patches of one pixel take 32


@dataclass(frozen=True)
class Facts:
    """What a saved result stores beside its arrays; see `Synthesis` for the fields."""

    shape: tuple[int, int]
    sample_shape: tuple[int, int]
    wrap: tuple[bool, bool]
    known_from: tuple[int, int] | None
    provenance: dict[str, Any]
    origin: tuple[int, int]
    match_tone: bool
    tone_reach: float
    is_window: bool
    turn: str | None
    copy_shape: tuple[int, int] | None

    def __post_init__(self) -> None:
        for name in ("shape", "sample_shape"):
            if not _whole(getattr(self, name)) or min(getattr(self, name)) < 1:
                raise DamageError("its sizes are invalid")
        if math.prod(self.shape) > MAX_PIXELS or math.prod(self.sample_shape) > MAX_PIXELS:
            raise DamageError("its sizes are larger than any image of weftex")
        if not _whole(self.origin) or not (self.known_from is None or _whole(self.known_from)):
            raise DamageError("its positions are invalid")
        switches = (*self.wrap, self.match_tone, self.is_window)
        if [*map(type, switches)] != [bool] * 4 or not isinstance(self.provenance, dict):
            raise DamageError("its description has other types")
        if type(self.tone_reach) is not float or not 0 <= self.tone_reach <= MOST_REACH:
            raise DamageError("its reach of tones is invalid")
        if self.turn is not None and gap_of(self.sample_shape, self.turn, self.copy_shape) != 1:
            raise DamageError("its copies do not fit its sample")

    def check_hole(self, bits: NDArray[Any] | None) -> NDArray[np.bool_] | None:
        """Unpack the hole, after a look at whether it and the known pixels fit the shapes."""
        if self.known_from is not None:
            ends = np.add(self.known_from, self.shape)
            if min(self.known_from) < 0 or (ends > self.sample_shape).any():
                raise DamageError("its known pixels lie outside the sample")
        if bits is None:
            return None
        if bits.dtype != np.uint8 or bits.shape != (self.shape[0], -(-self.shape[1] // 8)):
            raise DamageError("its hole does not fit its size")
        return np.unpackbits(bits, axis=1, count=self.shape[1]).astype(bool)


#: What a result is given beside its canvas, arrays and exemplar.
ABOUT = tuple(one.name for one in fields(Facts) if one.name not in ("shape", "wrap", "origin"))


def write_result(
    path: str | os.PathLike[str],
    facts: Facts,
    arrays: Mapping[str, NDArray[Any]],
    hole: NDArray[np.bool_] | None,
) -> None:
    """Write a result to a compressed `.npz` file; nothing is left behind if that fails."""
    bits = {} if hole is None else {"hole": np.packbits(hole, axis=1)}
    write_npz(path, {"format": _FORMAT, **asdict(facts)}, {**arrays, **bits})


def read_result(path: str | os.PathLike[str]) -> tuple[Facts, dict[str, NDArray[Any]]]:
    """Return the facts and the arrays that were written."""
    with open_npz(path) as file:
        about = file.facts
        number = about.pop("format")
        if number != _FORMAT:
            raise DamageError(f"its format is {number}, not {_FORMAT}")
        pairs = {k: tuple(v) for k, v in about.items() if isinstance(v, list)}
        facts = Facts(**about | pairs)
        beyond = facts.is_window * (_CELLS[0] * max(facts.sample_shape) + _CELLS[1])
        pixels = math.prod(n + beyond for n in facts.shape) + math.prod(facts.sample_shape)
        if file.size > _MOST_BYTES * pixels + MOST_FACTS:
            raise DamageError("its arrays are larger than its sizes need")
        return facts, file.read()


def arrays_of(
    types: Mapping[str, type], arrays: Mapping[str, NDArray[Any]], sample: tuple[int, int]
) -> dict[str, Any]:
    """Return those arrays that a kind of result has, after a look at their types."""
    own = {name: arrays[name] for name in types if name in arrays}
    if any(array.dtype != types[name] for name, array in own.items()):
        raise DamageError("its arrays have other types")
    if own.get("parts", np.empty(sample)).shape != sample:
        raise DamageError("its materials do not fit its sample")
    return own


def in_common(told: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Return what the provenances of all parts of a result say, and all their reasons."""
    same = {k: v for k, v in told[0].items() if all(v == one.get(k) for one in told)}
    reasons = dict.fromkeys(one["reason"] for one in told if "reason" in one)
    return same | ({"reason": "; ".join(reasons)} if reasons else {})


def _whole(pair: Any) -> bool:
    return isinstance(pair, tuple) and [*map(type, pair)] == [int, int]
