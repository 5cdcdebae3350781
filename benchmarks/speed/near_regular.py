"""Near-regular textures: lattices, correlation, blocks, windows of an endless plane."""

from __future__ import annotations

import statistics
from time import process_time

import numpy as np
from shared import Table, Work, child, medians, ms, sample_of, sized, some

import weftex
from weftex.analysis.correlation import correlate
from weftex.analysis.lattice import find_lattice

_SHIFTS = 400  # that the direct definition is timed on
_FAR = 10**9
_SIDE = 512


def bricks(side: int) -> np.ndarray:
    """A crop of bricks, or a larger wall of the same lattice."""
    if side <= 256:
        return sample_of(side, "bricks")
    return weftex.synthesize(sample_of(256, "bricks"), side, method="near-regular", seed=0).image


def direct(pixels: np.ndarray) -> float:
    """Seconds that the correlation of a picture with itself takes by its definition (eq. 3.2).

    The mean of random shifts, each with its two overlaps in array code, times all shifts.
    """
    height, width = pixels.shape[:2]
    rng = np.random.default_rng(0)
    picture = pixels.astype(np.float64)
    times = []
    for _ in some(range(_SHIFTS)):
        y, x = int(rng.integers(1 - height, height)), int(rng.integers(1 - width, width))
        start = process_time()
        f = picture[max(y, 0) : height + min(y, 0), max(x, 0) : width + min(x, 0)]
        g = picture[max(-y, 0) : height - max(y, 0), max(-x, 0) : width - max(x, 0)]
        above, below = 0.0, 0.0
        for k in range(pixels.shape[2]):  # eq. 3.10
            a, b = f[..., k] - f[..., k].mean(), g[..., k] - g[..., k].mean()
            above += float((a * b).sum())
            below += float((a * a).sum() * (b * b).sum()) ** 0.5
        _ = above / below if below else 0.0
        times.append(process_time() - start)
    return statistics.fmean(times) * (2 * height - 1) * (2 * width - 1)


def windows(model: weftex.NearRegularModel) -> Work:
    """Windows of 256 pixels, far away and each at another place."""
    places = iter(range(10**9))
    side = sized(256)
    return lambda: model.window(_FAR + 999 * next(places), -_FAR, side, side, seed=7).image


def near_regular() -> Table:
    """Lattice, correlation, synthesis and windows beside targets."""
    small, large = bricks(256), bricks(512)
    crop = weftex.NearRegular(defaults="paper", lattice=find_vectors(small))
    blocks = crop.fit(weftex.Exemplar(bricks(128)))
    own = weftex.NearRegular().fit(weftex.Exemplar(small))
    seeds = iter(range(10**9))
    took = medians(
        {
            "lattice": lambda: find_lattice(weftex.Exemplar(small)),
            "large": lambda: find_lattice(weftex.Exemplar(large)),
            "correlation": lambda: correlate(small),
            "blocks": lambda: blocks.sample(sized(256), seed=next(seeds)).image,
            "window": windows(own),
            "still": lambda: own.sample(sized(_SIDE), seed=next(seeds)).image,
        },
        15,
    )
    brute = direct(small)
    run = child(method="near-regular", side=256, size=8192, name="bricks")
    speed = 8192**2 / run["sample"] / 1e6
    rows = [
        ["lattice of 256x256", ms(took["lattice"]), "150 ms"],
        ["lattice of 512x512", ms(took["large"]), "0.6 s"],
        ["correlation of 256x256", ms(took["correlation"]), ""],
        ["the same by its definition", f"{brute / 60:.3g} min", ""],
        ["ratio of the two", f"{brute / took['correlation']:.0f} x", "1000 x"],
        ["128 to 256, blocks of 40, sample", ms(took["blocks"]), "15 ms"],
        ["256 to 8192, sample", ms(run["sample"]), ""],
        ["the same, megapixels/s", f"{speed:.3g}", "15"],
        ["the same, peak memory", f"{run['peak']:.0f} MiB", "1024 MiB"],
        ["256 at 10^9, -10^9", ms(took["window"]), "20 ms"],
        [f"256 to {_SIDE}, sample", ms(took["still"]), ""],
    ]
    notes = f"""
Bricks, RGB, defaults but for the blocks, which are the paper's. The definition is the time of
{_SHIFTS} random shifts in array code, extrapolated to all {(2 * 256 - 1) ** 2} shifts. 256 to 8192
is made once, in a process of its own whose memory is meant, picture included.
"""
    return notes, ["", "", "target"], rows


def find_vectors(pixels: np.ndarray) -> tuple[float, ...]:
    """The vectors of a sample as a method takes them."""
    lattice = find_lattice(weftex.Exemplar(pixels))
    assert lattice is not None
    return tuple(part for vector in lattice.reduced().vectors for part in vector)


TABLES = (near_regular,)
