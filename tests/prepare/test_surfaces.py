"""Heights, normals and ambient occlusion from each other."""

import numpy as np
import pytest

import weftex
from families import noise, refused
from weftex.prepare import height_from_normals, normals_from_height, occlusion_from_height


def stones():
    """A surface 96x128, from 0 to 1."""
    height = weftex.load_exemplar("sample:stone_wall").maps["height"][:96, :128]
    height = height if height.ndim == 2 else height[..., 0]
    return (height - height.min()) / np.ptp(height)


@pytest.mark.parametrize("y_up", [True, False])
@pytest.mark.parametrize("tileable", [True, False])
@pytest.mark.parametrize(
    ("dtype", "error"), [(np.float64, 1e-9), (np.float32, 1e-4), (np.uint16, 1e-3), (np.uint8, 0.1)]
)
def test_normals_and_back_give_the_same_height(tileable, y_up, dtype, error):
    high = stones()
    if tileable:  # without the three waves of two pixels that central differences cannot see
        spectrum = np.fft.fft2(high)
        spectrum[[48, 48, 0], [0, 64, 64]] = 0
        high = np.fft.ifft2(spectrum).real
        high = (high - high.min()) / np.ptp(high)
    how = {"y_up": y_up, "tileable": tileable}
    normals = normals_from_height(high, 12, dtype=dtype, **how)
    assert normals.dtype == dtype and normals.shape == (96, 128, 3)
    assert abs(height_from_normals(normals, **how) / 12 - high).max() < error
    other = height_from_normals(normals, y_up=not y_up, tileable=tileable) / 12
    assert abs(other - high).max() > 0.1


def test_conventions_and_units():
    ramp = np.arange(16) / 16 * np.ones((8, 1))
    up = normals_from_height(ramp, 32, dtype=np.float64)[4, 8]
    assert up == pytest.approx(np.array([-2, 0, 1]) / 5**0.5)  # it rises to the right by 2
    gl, dx = (normals_from_height(ramp.T, 32, y_up=up, dtype=np.float64)[8, 4]
              for up in (True, False))  # fmt: skip
    assert gl == pytest.approx(np.array([0, 2, 1]) / 5**0.5) and dx[1] == -gl[1]
    whole = np.rint(ramp * 65535).astype(np.uint16)
    assert abs(normals_from_height(whole, 32).astype(int) - normals_from_height(ramp, 32)).max() < 2
    flat = normals_from_height(np.full((40, 60), 7, np.uint8), 6)
    assert np.ptp(height_from_normals(flat)) == 0


def slow_occlusion(high, radius):
    """The horizon by all pixels within the radius of 16 directions' lines."""
    found = np.zeros(high.shape)
    for y, x in np.ndindex(high.shape):
        for turn in np.arange(16) * np.pi / 8:
            slope = 0.0
            for r in range(1, radius + 1):
                dy, dx = round(r * np.sin(turn)), round(r * np.cos(turn))
                other = high[(y + dy) % high.shape[0], (x + dx) % high.shape[1]]
                slope = max(slope, (other - high[y, x]) / np.hypot(dy, dx))
            found[y, x] += 1 / (1 + slope**2) / 16
    return found


def test_occlusion_is_its_definition_and_wraps():
    high = 3 * noise((12, 14), "float64")
    found = occlusion_from_height(high, 1, radius=6, tileable=True)
    assert abs(found - slow_occlusion(high, 6)).max() < 1e-5
    moved = occlusion_from_height(np.roll(high, (5, 3), (0, 1)), 1, radius=6, tileable=True)
    assert abs(moved - np.roll(found, (5, 3), (0, 1))).max() < 1e-6


def test_occlusion_of_a_long_trench_is_that_of_its_walls():
    trench = np.ones((65, 65))
    trench[:, 22:43] = 0
    found = occlusion_from_height(trench, 1000, radius=32)
    assert found[32, 32] < 0.2 and found[32, 5] == 1
    assert np.ptp(occlusion_from_height(np.ones((5, 9)), 6)) == 0


@pytest.mark.parametrize(
    "function, arguments, how, message",
    [
        (normals_from_height, (noise((4, 4, 3)), 6), {}, r"\(4, 4, 3\); it must be \(H, W\)"),
        (normals_from_height, (noise((4, 4)), 0), {}, "relief is 0; it must be above 0"),
        (height_from_normals, (noise((4, 4)),), {}, r"it must be \(H, W, 3\)"),
        (occlusion_from_height, (noise((4, 4)), 6), {"radius": 0}, "radius is 0"),
    ],
)
def test_bad_input(function, arguments, how, message):
    refused(message, function, *arguments, **how)
