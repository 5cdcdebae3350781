"""The thesis on near-regular textures: GNCC (section 3.2), and blocks and gaps (4.2)."""

import numpy as np

import weftex
from families import noise
from random_cases import random_cases, random_crop
from twins.lattice import normalized_correlation
from weftex import reference
from weftex.analysis.correlation import correlate
from weftex.methods.near_regular import blocks


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


@random_cases(24)
def test_near_regular_is_the_reference(rng, monkeypatch):
    """Of any lattice, where no block avoids to repeat what is near it: all of section 4.2."""
    monkeypatch.setattr(blocks, "_DRAWN_NEAR", [(0, 0)])
    sample = random_crop(rng, 70, 74) // 2 + noise((70, 74, 3), rng=rng) // 2  # without ties
    vectors = rng.uniform([(0, 7), (-10, 0)], [(4, 12), (-8, 4)])
    block, border, blend = (int(rng.integers(6, 9)), *(2 * rng.integers((1, 0), 3)).tolist())
    tolerance, match, seed = int(rng.integers(4)), str(rng.choice(["difference", "gncc"])), 3
    size = [int(n) for n in rng.integers(5, 60, 2)]
    expected = reference.near_regular(
        sample, size, vectors, block, border, blend, tolerance, match, seed
    )
    joints = {"blend": "feather", "blend_width": blend} if blend else {"blend": "none"}
    method = weftex.NearRegular(
        defaults="paper", lattice=tuple(vectors.ravel().tolist()), block_size=block,
        border_width=border, tolerance=tolerance, match=match, **joints,
    )  # fmt: skip
    result = method.fit(weftex.Exemplar(sample)).sample(size, seed=seed)
    assert abs(result.image.astype(int) - expected.image).max() <= (1 if blend else 0)
