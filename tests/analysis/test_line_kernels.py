"""Sums along lines, and what follows from them, beside slow twins."""

import numpy as np
import pytest

from weftex.analysis import kernels
from weftex.analysis.lines import _profiles, edges_of
from weftex.analysis.relief import Relief


@pytest.mark.parametrize("angle", [0.0, 0.3, 1.2, np.pi / 2, 2.9])
@pytest.mark.parametrize("shape", [(24, 31), (40, 17)])
def test_edges_are_added_up_line_by_line(angle, shape, rng):
    usable = np.ones(shape)
    usable[4:9, 5:8] = 0
    joints = edges_of(Relief(rng.normal(size=(2, *shape)), usable, 1))
    total, count = joints.lines(angle)
    height, width = shape
    c, s = np.cos(angle), np.sin(angle)
    along = min(height / max(abs(s), 1e-9), width / max(abs(c), 1e-9)) / 2
    edges, number = np.zeros(total.shape), np.zeros(total.shape, int)
    for y, x in np.ndindex(shape):
        v, u = y - (height - 1) / 2, x - (width - 1) / 2
        line = int(c * v + total.shape[1] / 2 - s * u)
        strip = int((s * v + along + c * u) * 4 / (2 * along))
        if joints.inner[y, x] and 0 <= line < total.shape[1] and 0 <= strip < 4:
            across = np.array([-s, c])  # of the lines: steps along it are what they are fields by
            xx, xy, yy = joints.parts[:, y, x]
            edges[strip, line] += across @ np.array([[xx, xy], [xy, yy]]) @ across
            number[strip, line] += 1
    assert (count == number).all() and 0 < count.sum() <= joints.inner.sum()
    np.testing.assert_allclose(total, edges, atol=1e-9)


def test_profiles_are_means_along_lines(rng):
    correlation = rng.normal(size=(39, 59))
    angles = np.array([0.0, 0.4, np.pi / 2, 2.0])
    found = _profiles(correlation, angles, 14)
    for k, angle in enumerate(angles):
        c, s = np.cos(angle), np.sin(angle)
        far = min(30 / max(abs(c), 1e-9), 20 / max(abs(s), 1e-9))
        for distance in range(14):
            values = []
            for share in np.linspace(-0.5, 0.5, 61):
                x, y = share * far * c - distance * s, share * far * s + distance * c
                row, column = np.clip(round(y) + 19, 0, 38), np.clip(round(x) + 29, 0, 58)
                values.append(correlation[row, column])
            assert found[k, distance] == pytest.approx(np.mean(values))


@pytest.mark.parametrize("window", [1, 2, 3])
def test_tops_are_peaks_within_a_window(window, rng):
    correlation = rng.normal(size=(21, 27))
    places = np.stack([rng.integers(-14, 15, 80), rng.integers(-11, 12, 80)], axis=1)
    found, heights = np.empty((80, 2)), np.empty(80)
    kernels.tops(correlation, places, window, found, heights)
    framed = np.pad(correlation, 9, mode="edge")
    for (x, y), at, height in zip(places, found, heights, strict=True):
        row, column = y + 10 + 9, x + 13 + 9
        near = framed[row - window :, column - window :][: 2 * window + 1, : 2 * window + 1]
        dy, dx = np.unravel_index(near.argmax(), near.shape)
        v, u = row - window + dy, column - window + dx
        top = framed[v, u]
        beside = framed[v, u - 1], framed[v, u + 1], framed[v - 1, u], framed[v + 1, u]
        assert height == (top if top >= max(beside) and top > 0 else 0)
        if height:
            pairs = beside[:2], beside[2:]  # not np.polyfit: its errors decide where a top is flat
            parabolas = [((left + right) / 2 - top, (right - left) / 2) for left, right in pairs]
            off = [np.clip(-b / (2 * min(a, -5e-13)), -0.5, 0.5) for a, b in parabolas]
            np.testing.assert_allclose(at, [u - 22 + off[0], v - 19 + off[1]], atol=1e-6)
