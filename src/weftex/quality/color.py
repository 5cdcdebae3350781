"""Color: whether colors occur as often as in the sample."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from weftex.quality.patches import at_quantiles
from weftex.quality.view import View, over_halves, some
from weftex.random import draw

if TYPE_CHECKING:
    from numpy.typing import NDArray

_PIXELS = 2**15
_QUANTILES = 256
_DIRECTIONS = 12
_FLOOR = 1.0  # of 255


def color_distance(sample: View, result: View) -> tuple[float | None, float | None]:
    """Return the distance of color distributions in 255ths, and over that of the sample's halves.

    The Wasserstein distance, in the mean over each channel and 12 random mixtures of them. Halves
    closer than 1 of 255 count as 1.
    """
    apart, own = _apart(sample, result), over_halves(sample, _apart)
    return apart, None if own is None or apart is None else apart / max(own, _FLOOR)


def _apart(first: View, second: View) -> float | None:
    if not (first.usable.any() and second.usable.any()):
        return None
    values = [_quantiles(view) for view in (first, second)]
    return float(abs(values[0] - values[1]).mean())


def _quantiles(view: View) -> NDArray[np.float64]:
    # The spelling of a purpose is part of the bits that are drawn for it.
    places = some(np.flatnonzero(view.usable), _PIXELS, "colours")
    channels = view.values.shape[2]
    pixels = np.ascontiguousarray(view.values.reshape(-1, channels)[places].T, np.float32)
    bits = draw(0, "measure colours", np.arange(_DIRECTIONS)[:, None], np.arange(channels))
    mixtures = (bits % np.uint64(17)).astype(np.float32) - 8
    mixtures[~mixtures.any(axis=1)] = 1
    values, lengths = pixels, np.ones(channels)
    if channels > 1:
        # Products of small integers: exact, so the same on every machine.
        values = np.concatenate([pixels, np.einsum("dk,kn->dn", mixtures, pixels)])
        lengths = np.append(lengths, np.sqrt((mixtures.astype(np.float64) ** 2).sum(axis=1)))
    return at_quantiles(values.astype(np.int32), _QUANTILES) / lengths[:, None]
