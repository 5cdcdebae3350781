"""Section 3.2 of the thesis on near-regular textures, GNCC; and 4.2.2, the pieces of gaps."""

import numpy as np

import weftex
from random_cases import random_cases, random_crop
from twins.lattice import normalized_correlation
from weftex.analysis.correlation import correlate


@random_cases(30)
def test_gncc_is_its_definition(rng):
    """Eqs. 3.2 and 3.10 at every shift asked for."""
    height, width = rng.integers(1, 14, 2)
    pixels = random_crop(rng, height, width)[..., : rng.integers(1, 4)].astype(float)
    mask = rng.random((height, width)) < 0.7 if rng.integers(2) else None
    reach = tuple(rng.integers(0, 16, 2).tolist()) if rng.integers(2) else None
    down, along = np.minimum(reach or (height, width), (height - 1, width - 1))
    whole = normalized_correlation(pixels, mask)
    expected = whole[height - 1 - down : height + down, width - 1 - along : width + along]
    found = correlate(np.moveaxis(pixels, 2, 0), mask, reach)
    np.testing.assert_allclose(found, expected, atol=1e-9)


@random_cases(20)
def test_a_gap_gets_the_piece_that_fits_its_border_best(rng):
    """Of all windows up to the tolerance from those that the lattice makes similar."""
    sample = random_crop(rng, 70, 74).astype(int)
    vectors = np.array([[rng.integers(7, 12), rng.integers(4)], [rng.integers(4), -9]])
    block, border, tolerance = (int(k) for k in (rng.integers(6, 9), 2 * rng.integers(1, 3), 2))
    method = weftex.NearRegular(
        defaults="paper", lattice=tuple(vectors[:, ::-1].ravel().tolist()), block_size=block,
        border_width=border, tolerance=tolerance, match=str(rng.choice(["difference", "gncc"])),
        blend="none",
    )  # fmt: skip
    result = method.fit(weftex.Exemplar(sample.astype(np.uint8))).sample(5 * block, seed=3)
    side, margin = block + border, border // 2
    ends = np.stack([*np.indices((side, side)), *np.indices((side, side))[:, ::-1, ::-1]])
    nearest, wedge = ends.argmin(axis=0), ends.min(axis=0) < border
    windows = np.lib.stride_tricks.sliding_window_view(sample, (side, side), (0, 1))
    windows = np.moveaxis(windows, 2, -1)
    for i, j in ((1, 2), (2, 1), (2, 3), (3, 2)):
        places = {
            (a, b): result.source[(i + a) * block, (j + b) * block] - margin
            for a, b in ((0, 0), (-1, 0), (0, -1), (1, 0), (0, 1))
        }
        colors = np.zeros((side, side, 3), int)
        for k, (a, b) in enumerate(((-1, 0), (0, -1), (1, 0), (0, 1))):
            v, u = np.nonzero((nearest == k) & wedge)
            y, x = places[a, b] - (a * block, b * block)
            colors[v, u] = sample[y + v, x + u]
        phase = (np.indices(windows.shape[:2]).transpose(1, 2, 0) - places[-1, 0]) - (block, 0)
        times = phase @ np.linalg.inv(vectors)
        similar = abs(times - np.rint(times)).max(axis=2) < 1e-6
        near = np.zeros_like(similar)
        for y, x in np.argwhere(similar):
            near[
                max(0, y - tolerance) : y + tolerance + 1, max(0, x - tolerance) : x + tolerance + 1
            ] = True
        places_near, chosen = np.argwhere(near).tolist(), places[0, 0].tolist()
        fits, colors = windows[near][:, wedge], colors[wedge]
        errors = ((fits - colors) ** 2).sum(axis=(1, 2))
        if method.match == "gncc":  # eq. 3.13
            fits, colors = (one - one.mean(axis=-2, keepdims=True) for one in (fits, colors))
            energy = np.sqrt((fits**2).sum(axis=1)) * np.sqrt((colors**2).sum(axis=0))
            errors = -(fits * colors).sum(axis=(1, 2)) / np.maximum(energy.sum(axis=1), 1e-9)
        assert errors[places_near.index(chosen)] <= errors.min() + 1e-9
