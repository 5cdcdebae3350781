"""The dominant scale: right where it is known, unmoved by what must not count, honest elsewhere."""

import math

import numpy as np
import pytest

import weftex
from families import noise
from weftex.analysis.relief import relief
from weftex.analysis.scale import THICKNESS, _ring_power, structure_scale
from weftex.analysis.widths import between_joints, over_squares
from weftex.exemplar import Exemplar

#: What the estimate is for the samples that ship with weftex: pixels, confidence and source.
REAL = {
    "pebbles": (15.66, 0.95, "things"),  # they measure 10 to 20, and are strewn
    "bricks": (41.77, 0.94, "lattice"),  # six courses to 256 pixels are 42.7
    "grass": (14.22, 0.95, "things"),  # blades are 5 to 15 wide
    "weave": (12.37, 0.95, "lattice"),  # a thread is 12.5 wide
    "tiles": (31.05, 0.95, "lattice"),  # eight joints to 256 pixels
    "wood": (20.57, 0.3, "things"),  # grain of 5 to 10 in figures of 100
    "leaves": (42.99, 0.79, "things"),  # they measure 30 to 50
}


def found(pixels, **options):
    return structure_scale(Exemplar(np.ascontiguousarray(pixels), **options))


def levels(values):
    """Values from -1 to 1 as bytes."""
    return np.rint(127.5 + 120 * values).astype(np.uint8)


def grating(height, width, period, angle=0.0):
    y, x = np.mgrid[:height, :width]
    return np.sin(2 * np.pi * (x * math.cos(angle) + y * math.sin(angle)) / period)


def colored_noise(side, seed, exponent):
    """Noise whose amplitude falls with that power of the frequency: pictures have about 1."""
    noise = np.fft.fft2(np.random.default_rng(seed).standard_normal((side, side)))
    f = np.hypot(np.fft.fftfreq(side)[:, None], np.fft.fftfreq(side))
    f[0, 0] = 1
    waves = np.fft.ifft2(noise / f**exponent).real
    return levels(np.clip(waves / (3 * waves.std()), -1, 1))


def ring_power_by_definition(pixels):
    """P(r): fade the borders, transform, gather the rings with their neighbors."""
    flat = relief(Exemplar(pixels))
    height, width = flat.usable.shape
    side = max(height, width)
    fade = np.outer(*(np.sin(np.pi * (np.arange(n) + 0.5) / n) ** 2 for n in (height, width)))
    faded = flat.levels * fade
    faded -= faded.sum(axis=(1, 2), keepdims=True) * fade / fade.sum()
    rows, columns = min(side, 2 * height), min(side, 2 * width)
    power = (abs(np.fft.fft2(faded, (rows, columns))) ** 2).sum(axis=0)
    v, u = abs(np.fft.fftfreq(rows))[:, None], abs(np.fft.fftfreq(columns))
    counts = (v * height >= 1.49) | (u * width >= 1.49)
    rings, power = np.rint(side * np.hypot(v, u) / THICKNESS + 1e-9)[counts], power[counts]
    result = []
    for ring in range(int(rings.max()) + 1):
        near = np.where(abs(rings - ring) < 10, np.cos(np.pi * (rings - ring) / 20) ** 2, 0)
        mean = (near * power).sum() / near.sum() if near.sum() > 1e-9 else 0.0
        places = max(2 * np.pi * ring * THICKNESS * height * width / side**2, 2)
        result.append(places * THICKNESS * mean)
    return result


@pytest.mark.parametrize("shape", [(12, 12), (9, 14, 3), (15, 8), (1, 16)])
def test_ring_power_is_its_definition(shape, rng):
    pixels = rng.integers(0, 256, shape, np.uint8)
    expected = ring_power_by_definition(pixels)
    power = _ring_power(relief(Exemplar(pixels)))[0][: len(expected)]
    np.testing.assert_allclose(power, expected, rtol=1e-7, atol=1e-6 * max(expected))


@pytest.mark.parametrize("period", [5, 8, 11.3, 16, 21])
@pytest.mark.parametrize("shape", [(128, 128), (96, 160), (200, 90)])
def test_gratings(period, shape):
    for angle in (0, 0.5, math.pi / 2):
        scale = found(levels(grating(*shape, period, angle)))
        assert scale.scale == pytest.approx(period, rel=0.05)
        assert scale.confidence > 0.75


@pytest.mark.parametrize("direction", [(1, 0), (0, 1), (1, 1), (2, -1)])
def test_slow_lighting_does_not_count(direction):
    y, x = np.mgrid[-1:1:128j, -1:1:128j]
    lighting = 0.6 * np.cos(1.2 * (direction[0] * y + direction[1] * x) + 0.4)
    scale = found(levels(np.clip(0.25 * grating(128, 128, 13) + lighting, -1, 1)))
    assert scale.scale == pytest.approx(13, rel=0.05)
    assert scale.confidence > 0.75


@pytest.mark.parametrize("exponent", [0, 0.5, 1, 1.5])
def test_noise_has_no_period(exponent):
    scales = [found(colored_noise(128, seed, exponent)) for seed in range(20)]
    assert np.mean([s.source != "things" for s in scales]) <= 0.1


def strewn(side, size, rng):
    """Discs of one size and any gray, one over the other."""
    y, x = np.mgrid[:side, :side]
    levels = np.full((side, side), 0.0)
    for _ in range(3 * side**2 // size**2):
        v, u = rng.uniform(-size, side + size, 2)
        levels[(y - v) ** 2 + (x - u) ** 2 < size**2 / 4] = rng.uniform(-1, 1)
    return levels + 0.1 * rng.standard_normal((side, side))


@pytest.mark.parametrize("size", [8, 14, 24, 40])
def test_strewn_things(size, rng):
    scale = found(levels(np.clip(strewn(256, size, rng), -1, 1)))
    assert scale.source == "things" and scale.confidence > 0.5
    assert size <= scale.scale <= 2 * size  # they are plainer than stones, which have grain


@pytest.mark.parametrize("size", [30, 40, 50])
def test_stones_are_told_by_their_joints(size, rng):
    """Grain of any size hides the stones, and is as large without joints; grooves are no stones."""
    y, x = np.mgrid[:256, :256]
    corners = np.mgrid[-size : 256 + size : size, -size : 256 + size : size].reshape(2, -1, 1, 1)
    middles = corners + rng.uniform(0, 0.6 * size, corners.shape)
    near = np.sort(np.hypot(y - middles[0], x - middles[1]), axis=0)
    joint = (near[1] - near[0])[..., None] < 4
    grain = 128 + 30 * rng.standard_normal((64, 64, 1)).repeat(4, 0).repeat(4, 1)
    for tone in (-60, 60):
        drawn = np.clip(grain + tone * joint, 0, 255).astype(np.uint8)
        assert found(drawn).scale == pytest.approx(size, rel=0.25)
    assert between_joints(relief(Exemplar(grain.astype(np.uint8)))) == 0
    grooves = np.clip(
        grain - 60 * (np.cumsum(rng.uniform(0, 0.06, 256)) % 1 < 0.1)[:, None, None], 0, 255
    )
    assert between_joints(relief(Exemplar(grooves.astype(np.uint8)))) == 0


def test_things_of_many_sizes_are_less_sure(rng):
    one = strewn(256, 12, rng)
    many = 0.5 * one + 0.4 * strewn(256, 100, rng) + 0.1 * rng.standard_normal((256, 256))
    sure, unsure = (found(levels(np.clip(v, -1, 1))).confidence for v in (one, many))
    assert unsure < sure - 0.1


def test_openings_are_their_definition(rng):
    """Of the highest of the squares that hold a place, each by its lowest pixel."""
    pixels = rng.integers(0, 256, (23, 31)).astype(np.uint8)
    for size in (2, 3, 5):
        lowest = np.lib.stride_tricks.sliding_window_view(pixels, (size, size)).min(axis=(2, 3))
        expected = np.zeros(pixels.shape, np.uint8)
        for y, x in np.ndindex(lowest.shape):
            part = expected[y : y + size, x : x + size]
            np.maximum(part, lowest[y, x], out=part)
        around = np.pad(over_squares(pixels, size, np.minimum), size - 1)
        np.testing.assert_array_equal(over_squares(around, size, np.maximum), expected)


def test_a_pattern_in_noise_is_less_certain():
    rng = np.random.default_rng(5)
    noise = rng.standard_normal((128, 128))
    clear, faint = (
        found(levels(np.clip(amount * grating(128, 128, 10) + 0.3 * noise, -1, 1)))
        for amount in (0.5, 0.12)
    )
    assert clear.scale == pytest.approx(10, rel=0.05)
    assert faint.scale == pytest.approx(10, rel=0.05)
    assert 0.2 < faint.confidence < clear.confidence


@pytest.mark.parametrize("name", REAL)
def test_real_samples(name):
    """Within a ring: another machine's transforms may round what lies between two."""
    exemplar = weftex.load_exemplar(f"sample:{name}")
    result = structure_scale(exemplar)
    scale, confidence, source = REAL[name]
    assert result.source == source
    assert result.scale == pytest.approx(scale, abs=0.02)
    assert result.confidence == pytest.approx(confidence, abs=0.01)
    assert abs(result.window_width - 2 * scale) <= 2 and result.window_width % 2 == 1


@pytest.mark.parametrize("name", ["bricks", "pebbles", "weave", "leaves"])
def test_turned_samples(name):
    pixels = weftex.load_exemplar(f"sample:{name}").pixels
    expected = found(pixels)
    for turned in (np.rot90(pixels), pixels[::-1], pixels.swapaxes(0, 1)):
        again = found(turned)
        assert (again.scale, again.confidence) == (expected.scale, expected.confidence)


def test_half_of_a_sample_and_other_kinds_of_pixels():
    pixels = weftex.load_exemplar("sample:tiles").pixels
    for part in (pixels[:, :200], pixels[:120], pixels[::2, ::2]):
        step = 256 // part.shape[0] if part.shape[0] == part.shape[1] else 1
        assert found(part).scale == pytest.approx(32 / step, rel=0.07)
    expected = found(pixels).scale
    assert found(pixels.astype(np.uint16) * 257).scale == expected
    assert found(pixels.astype(np.float32) / 255).scale == expected
    assert found(pixels.mean(axis=2).astype(np.uint8)).scale == expected
    large = np.repeat(np.repeat(pixels, 5, axis=0), 5, axis=1)
    assert found(large).scale == pytest.approx(5 * expected, rel=0.02)


def test_colors_of_one_brightness_count():
    wave = np.rint(60 * grating(96, 96, 12)).astype(int)
    pixels = np.stack([128 + wave, 128 - wave, np.full_like(wave, 128)], axis=2)
    assert found(pixels.astype(np.uint8)).scale == pytest.approx(12, rel=0.05)


def test_what_the_mask_leaves_out_does_not_count():
    fine, coarse = grating(128, 128, 8), 2 * grating(128, 128, 30, 1.0)
    mask = np.zeros((128, 128), bool)
    mask[:, :80] = True
    mixed = levels(np.where(mask, fine, coarse) / 2)
    assert found(mixed, mask=mask).scale == pytest.approx(8, rel=0.05)
    assert found(mixed, mask=~mask).scale == pytest.approx(30, rel=0.2)
    holes = np.ones((128, 128), bool)
    holes[20:50, 30:60] = holes[80:100, 70:110] = False
    junk = levels(np.where(holes, fine / 2, 1.0))
    assert found(junk, mask=holes).scale == pytest.approx(8, rel=0.05)


@pytest.mark.parametrize("pixels", [
    *(np.full(shape, 77, np.uint8) for shape in ((40, 40), (8, 8, 3), (1, 300), (300, 1))),
    *(noise(shape) for shape in ((1, 1), (1, 7), (7, 7), (3, 3, 4))),
    np.add.outer(np.arange(60), np.arange(60)).astype(np.uint8),
], ids=lambda pixels: str(pixels.shape))  # fmt: skip
def test_constant_and_small_samples_and_lighting_alone(pixels):
    scale = found(pixels)
    assert (scale.scale, scale.confidence, len(scale.power)) == (1, 0, 0)
    assert scale.window_width == 3


def test_the_curve():
    scale = found(levels(grating(100, 140, 10)))
    assert len(scale.frequencies) == len(scale.power) == len(scale.background)
    assert (np.diff(scale.frequencies) > 0).all()
    assert scale.power.max() == 1 and scale.power.min() >= 0
    assert scale.frequencies[scale.power.argmax()] == pytest.approx(0.1, rel=0.03)
    assert scale.frequencies[0] * 140 == pytest.approx(2.5) and scale.frequencies[-1] <= 1 / 3
