"""Randomness that is the same on every machine, in any order and on any number of threads.

Every random number is a hash of (seed, purpose, place) and not the next number of a stream, so it
does not matter who asks first. The mixing function is SplitMix64's finalizer (Steele, Lea and
Flood, 2014). NumPy's own generators may change their streams between versions; this must not.
"""

from __future__ import annotations

import numbers
import os
from functools import lru_cache
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from weftex.errors import InvalidInputError, wrong_value

Seed: TypeAlias = "int | np.random.Generator | None"  # a string: naming it imports numpy.random

__all__ = ["draw", "pick", "seed_number"]

_GAMMA = np.uint64(0x9E3779B97F4A7C15)
_MIX1 = np.uint64(0xBF58476D1CE4E5B9)
_MIX2 = np.uint64(0x94D049BB133111EB)


def seed_number(seed: Seed) -> int:
    """The seed as an integer below 2**64; None draws one, a Generator gives its next 64 bits."""
    if seed is None:
        return int.from_bytes(os.urandom(8), "little")
    if isinstance(seed, numbers.Integral) and not isinstance(seed, bool):
        if not 0 <= int(seed) < 2**64:
            raise wrong_value("seed", seed, "from 0 to 2**64 - 1")
        return int(seed)
    if hasattr(seed, "integers"):
        return int(seed.integers(0, 2**64, dtype=np.uint64))
    kind = type(seed).__name__
    raise InvalidInputError(f"seed is a {kind}; it must be None, an integer or a numpy Generator")


def draw(seed: int, purpose: str, *place: NDArray[np.integer] | int) -> NDArray[np.uint64]:
    """64 random bits (uint64) for each of `place`, coordinates that broadcast; see `seed_number`.

    Bits for different purposes are independent.
    """
    state = _begun(seed, purpose)
    for coordinate in place:
        state = _mix(state ^ np.asarray(coordinate).astype(np.int64).view(np.uint64))
    return state.reshape(np.broadcast_shapes(*(np.shape(p) for p in place)))


def pick(
    options: NDArray[Any], seed: int, purpose: str, *place: NDArray[np.integer] | int
) -> NDArray[Any]:
    """Draw one of some options for each of `place`, all equally likely; see `draw`."""
    share = (draw(seed, purpose, *place) >> np.uint64(32)) * np.uint64(len(options))
    picked: NDArray[Any] = options[share >> np.uint64(32)]
    return picked


@lru_cache(maxsize=256)
def _begun(seed: int, purpose: str) -> NDArray[np.uint64]:
    """The bits (1,) that places are mixed into."""
    state = _mix(np.array([seed], np.uint64))
    for byte in purpose.encode() + b"\xff":  # no purpose goes on as another one or as a place
        state = _mix(state ^ np.uint64(byte))
    state.flags.writeable = False
    return state


def _mix(bits: NDArray[np.uint64]) -> NDArray[np.uint64]:
    bits = bits + _GAMMA
    bits = (bits ^ (bits >> np.uint64(30))) * _MIX1
    bits = (bits ^ (bits >> np.uint64(27))) * _MIX2
    return bits ^ (bits >> np.uint64(31))
