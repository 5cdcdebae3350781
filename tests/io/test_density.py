"""Pixels per meter in files, as other readers see them."""

import struct

import numpy as np
import pytest

import weftex
from commands import weft_run
from families import noise, refused
from picture_files import RGB_PROFILE, read_back
from weftex.io.pictures import read_image, write_image
from weftex.prepare import scaled

Image = pytest.importorskip("PIL.Image")


def stated(path):
    """Pixels per meter, by Pillow or by the attribute in the header of an EXR file."""
    if str(path).endswith(".exr"):
        data = path.read_bytes()
        name = b"xDensity\0float\0\4\0\0\0"
        start = data.index(name) + len(name)
        return struct.unpack("<f", data[start : start + 4])[0] / 0.0254
    with Image.open(path) as picture:
        across, down = picture.info["dpi"]
    assert across == down
    return across / 0.0254


@pytest.mark.parametrize(
    "suffix, error", [(".png", 0.5), (".tif", 0.01), (".exr", 0.01), (".jpg", 20)]
)
@pytest.mark.parametrize("density", [853.3333, 1000.0, 12345.6, 72 / 0.0254])
def test_formats_keep_the_density(tmp_path, suffix, error, density):
    pixels = noise((9, 8, 3), "float32" if suffix == ".exr" else "uint8")
    path = tmp_path / f"a{suffix}"
    write_image(path, pixels, density=density)
    assert stated(path) == pytest.approx(density, abs=error)
    found = read_image(path).density
    assert found == pytest.approx(stated(path), rel=1e-5)
    assert read_back(path, pixels, density=found).density == found  # it does not drift
    assert read_back(path, pixels).density is None


def test_pngs_with_a_profile_and_axes_that_differ(tmp_path):
    write_image(tmp_path / "a.png", noise((9, 8, 3)), icc=RGB_PROFILE, density=853.3)
    assert (read_image(tmp_path / "a.png").icc is not None) and stated(tmp_path / "a.png") == 853
    for suffix in ("png", "tif", "jpg"):
        Image.fromarray(noise((9, 8, 3))).save(tmp_path / f"b.{suffix}", dpi=(100, 200))
        assert read_image(tmp_path / f"b.{suffix}").density is None
        Image.fromarray(noise((9, 8, 3))).save(tmp_path / f"c.{suffix}", dpi=(300, 300))
        density = read_image(tmp_path / f"c.{suffix}").density
        assert density == pytest.approx(300 / 0.0254, rel=1e-4)
    refused("density is 0", write_image, tmp_path / "a.png", noise((4, 4)), density=0)


@pytest.mark.parametrize("suffix", ["png", "tif", "jpg"])
def test_commands_keep_it_and_sizes_are_in_meters(tmp_path, monkeypatch, capsys, suffix):
    monkeypatch.chdir(tmp_path)
    write_image("a.png", noise((40, 50, 3)))
    assert weft_run("prepare", "a.png", "-o", f"b.{suffix}", "--sample-width", "5cm") == 0
    quick = ["--method", "quilting", "--patch-size", 12, "--seed", 1, "--quiet"]
    assert weft_run("synth", f"b.{suffix}", "-o", f"c.{suffix}", "--size", "8cmx60mm", *quick) == 0
    assert read_image(f"c.{suffix}").pixels.shape == (60, 80, 3)
    assert weft_run("tile", f"c.{suffix}", "-o", f"d.{suffix}", *quick) == 0
    assert weft_run("estimate", f"d.{suffix}", "-o", "set", "--quiet") == 0
    assert weft_run("pack", "set", "-o", "packed", "--preset", "gltf", "--quiet") == 0
    written = [tmp_path / f"{name}.{suffix}" for name in "bcd"]
    written += [*(tmp_path / "set").iterdir(), *(tmp_path / "packed").glob("*.png")]
    assert len(written) > 9 and {round(stated(path)) for path in written} == {1000}
    capsys.readouterr()
    assert weft_run("synth", f"b.{suffix}", "-o", "e.png", "--size", "0.05m", *quick[:-1]) == 0
    assert "states 1000 pixels per meter, so it is 0.05 m wide" in capsys.readouterr().err


def test_maps_of_other_sizes_have_other_densities(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "set").mkdir()
    write_image("set/color.png", noise((40, 50, 3)))
    write_image("set/height.png", noise((80, 100)))
    words = ["--sample-width", "0.1m", "--size", "0.1mx0.08m", "--method", "quilting"]
    assert weft_run("synth", "set", "-o", "out", *words, "--quiet") == 0
    assert [stated(tmp_path / "out" / f"{k}.png") for k in ("color", "height")] == [500, 1000]


def test_density_scales_all_maps(tmp_path, monkeypatch):
    """By the filter that Pillow has, too; normals stay unit vectors of the same slopes."""
    monkeypatch.chdir(tmp_path)
    y, x = np.mgrid[:120, :160] / 20
    slopes = np.dstack([np.cos(x), np.cos(y), np.full_like(x, 2)])
    vectors = slopes / np.linalg.norm(slopes, axis=2, keepdims=True)
    (tmp_path / "set").mkdir()
    color = noise((120, 160, 3))
    write_image("set/color.png", color)
    write_image("set/normal_gl.png", np.rint(vectors * 127.5 + 127.5).astype(np.uint8))
    write_image("set/height.png", noise((60, 80), "uint16"))
    words = ["--sample-width", "16cm", "--density", "500px/m"]
    assert weft_run("prepare", "set", "-o", "out", *words, "--quiet") == 0
    found = {name: read_image(f"out/{name}.png") for name in ("color", "normal_gl", "height")}
    assert [one.pixels.shape[:2] for one in found.values()] == [(60, 80), (60, 80), (30, 40)]
    assert [round(one.density) for one in found.values()] == [500, 500, 250]
    expected = Image.fromarray(color).resize((80, 60), Image.Resampling.LANCZOS)
    assert abs(found["color"].pixels - np.asarray(expected, float)).mean() < 2
    half = found["normal_gl"].pixels / 127.5 - 1
    assert abs(np.linalg.norm(half, axis=2) - 1).max() < 0.01
    assert abs(half - vectors[::2, ::2]).max() < 0.06 and half.dtype == float
    assert weft_run("synth", "set", "-o", "more", *words, "--size", "0.2m", "--quiet") == 0
    assert read_image("more/color.png").pixels.shape == (100, 100, 3)


def test_scaled_tiles_stay_tileable():
    tile = noise((24, 30, 3))
    moved, whole = (
        scaled(weftex.Exemplar(one, tileable=True), 2.0).pixels
        for one in (np.roll(tile, (7, 11), (0, 1)), tile)
    )
    assert np.array_equal(moved, np.roll(whole, (14, 22), (0, 1)))


def test_planes_keep_the_density(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_image("a.png", noise((40, 50, 3)), density=853)
    words = ["--size", "150", "--block", "64", "--method", "quilting", "--patch-size", "12"]
    assert weft_run("synth", "a.png", "-o", "b.tif", *words, "--seed", "1", "--quiet") == 0
    assert stated(tmp_path / "b.tif") == pytest.approx(853, abs=0.01)
    assert read_image("b.tif").density == pytest.approx(853, abs=0.01)
