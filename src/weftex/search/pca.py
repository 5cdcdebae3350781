"""Principal components of boundary zones (section 3.3), in integers.

The components are rounded to integers and so are the coordinates. A matrix product of integers is
exact in floating point as long as no sum passes 2**24, whatever the order of summation; so the
coordinates, and with them the candidates, are the same on every machine and thread count.
"""

from __future__ import annotations

import os
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

_VARIANCE = 0.97  # that components keep, as in the paper
MOST_COMPONENTS = 48  # keeps a sum of squares in the kernel under 2**31
_MOST_LEARNED = 4096  # windows that the components are learned from
_LONGEST_VECTOR = 2047  # of coordinates


@dataclass(frozen=True, eq=False)
class ZonePCA:
    """Coordinates of all windows of a sample in the main components of their boundary zones."""

    basis: NDArray[np.int16]  # (D, K): components, scaled and rounded
    offset: NDArray[np.int32]  # (D,): subtracted from a product with `basis`
    shift: int  # to the right, with rounding, which brings coordinates to their range
    features: NDArray[np.int16]  # (D, n): of the windows; one component is one row


@cache
def _blas() -> Any:
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()


def one_blas_thread() -> AbstractContextManager[Any]:
    """Return a context that keeps BLAS to one thread.

    Its threads busy-wait, so a product of a millisecond takes a tenth of a second beside other
    work. Rounding must not depend on their number either.
    """
    if os.environ.get("OPENBLAS_NUM_THREADS") == "1":
        return nullcontext()
    limit: AbstractContextManager[Any] = _blas().limit(limits=1, user_api="blas")
    return limit


def fit_pca(windows: NDArray[np.uint8], variance: float = _VARIANCE) -> ZonePCA:
    """Return the components of the columns of `windows`, (K, n), and the columns' coordinates.

    At most 48 components keep this share of the variance.
    """
    size, count = windows.shape
    with one_blas_thread():
        learn = windows[:, np.linspace(0, count - 1, min(count, _MOST_LEARNED)).astype(np.int64)]
        learn = learn.astype(np.float64)
        # Integers in float64: the products and sums are exact, so every machine gets this matrix.
        scatter = learn.shape[1] * (learn @ learn.T) - np.outer(
            learn.sum(axis=1), learn.sum(axis=1)
        )
        power, vectors = np.linalg.eigh(scatter)
        vectors = main_components(power, vectors, variance)
        unit = min(2000.0, 0.95 * 2**24 / (255 * size**0.5))
        basis = np.ascontiguousarray(np.rint(vectors * unit), np.int16)
        weights = basis.astype(np.float32)
        raw = np.empty((len(basis), count), np.int32)
        for start in range(0, count, 8192):
            part = windows[:, start : start + 8192].astype(np.float32)
            raw[:, start : start + 8192] = weights @ part
        return ZonePCA(basis, *coordinates_of(raw))


def main_components(
    power: NDArray[np.float64], vectors: NDArray[np.float64], variance: float
) -> NDArray[np.float64]:
    """Return the main eigenvectors from `eigh` as rows, with a positive largest entry.

    They keep this share of the variance, unless that takes more than `MOST_COMPONENTS`.
    """
    power, vectors = power[::-1].clip(0), vectors[:, ::-1]
    reached = np.cumsum(power) >= variance * power.sum()
    needed = int(np.argmax(reached)) + 1 if reached.any() else len(power)
    kept = vectors[:, : min(needed, MOST_COMPONENTS)].T
    largest = np.abs(kept).argmax(axis=1)
    result: NDArray[np.float64] = kept * np.sign(kept[np.arange(len(kept)), largest])[:, None]
    return result


def coordinates_of(raw: NDArray[np.integer]) -> tuple[NDArray[np.int32], int, NDArray[np.int16]]:
    """Return `offset`, `shift`, `features` of `ZonePCA`: products with components, in 16 bits.

    `raw` has one component a row. No window is further than 2047 from 0.
    """
    offset = ((raw.max(axis=1) + raw.min(axis=1)) // 2).astype(np.int32)
    raw = raw - offset[:, None]
    longest = float(np.sqrt((raw.astype(np.float64) ** 2).sum(axis=0).max()))
    shift = 0
    while longest / 2**shift > _LONGEST_VECTOR:
        shift += 1
    features = ((raw + ((1 << shift) >> 1)) >> shift).astype(np.int16)
    return offset, shift, np.ascontiguousarray(features)
