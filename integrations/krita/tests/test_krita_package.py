"""What can be checked without Krita: the package, its Python files, pixels and the options."""

import ast
import configparser
import importlib
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[3]


@pytest.fixture(scope="module")
def archive(tmp_path_factory):
    """The ZIP file, and the folder that it is unpacked in."""
    folder = tmp_path_factory.mktemp("krita")
    build = [sys.executable, str(ROOT / "integrations" / "build.py"), "krita"]
    subprocess.run([*build, "--output", str(folder)], check=True, timeout=120)
    with zipfile.ZipFile(folder / "weftex_krita.zip") as packed:
        packed.extractall(folder)
        return packed.namelist(), folder


@pytest.fixture(scope="module")
def pixels(archive):
    sys.path.insert(0, str(archive[1]))
    yield importlib.import_module("weftex_krita.pixels")
    sys.path.remove(str(archive[1]))


def test_the_package_has_the_layout_that_krita_imports(archive):
    names, folder = archive
    desktop = configparser.ConfigParser()
    desktop.read(folder / "weftex_krita.desktop", "utf-8")
    assert desktop["Desktop Entry"]["ServiceTypes"] == "Krita/PythonPlugin"
    module = desktop["Desktop Entry"]["X-KDE-Library"]
    # Krita's importer looks for the folder itself, and for its __init__.py.
    assert f"{module}/" in names and f"{module}/__init__.py" in names
    assert {f"{module}/{name}" for name in ("command.py", "tiff.py", "options.json")} <= set(names)
    for path in folder.glob("weftex_krita/*.py"):
        ast.parse(path.read_text("utf-8"), feature_version=(3, 8))


@pytest.mark.parametrize(
    "depth, dtype", [("U8", "u1"), ("U16", "u2"), ("F16", "f2"), ("F32", "f4")]
)
@pytest.mark.parametrize("model, channels", [("RGBA", 4), ("GRAYA", 2)])
@pytest.mark.parametrize("opaque", [True, False])
def test_pixels_reach_a_picture_and_come_back(pixels, depth, dtype, model, channels, opaque):
    draw = np.random.default_rng(1)
    own = (draw.random((5, 7, channels)) * 250).astype(dtype)
    if opaque:
        own[..., -1] = np.iinfo(dtype).max if own.dtype.kind == "u" else 1
    picture = pixels.to_picture(own.tobytes(), 7, 5, model, depth)
    assert picture.channels == channels - opaque
    values = np.frombuffer(picture.data, np.float32 if own.dtype.kind == "f" else dtype)
    swap = model == "RGBA" and own.dtype.kind == "u"
    expected = own[..., ([2, 1, 0, 3] if swap else list(range(channels)))[: picture.channels]]
    assert (values.reshape(5, 7, -1) == expected).all()
    assert pixels.from_picture(picture, depth) == own.tobytes()


def test_a_mask_becomes_alpha(pixels):
    own = np.full((1, 3, 4), 200, np.uint8)
    own[..., 3] = [255, 255, 100]
    picture = pixels.to_picture(own.tobytes(), 3, 1, "RGBA", "U8")
    covered = pixels.covered(picture, bytes([0, 128, 255]))
    assert list(covered.data[3::4]) == [0, 128, 100] and covered.data[0] == 200
    crop = covered.cropped(1, 0, 2, 1)
    assert (crop.width, crop.height) == (2, 1) and crop.data == covered.data[4:]


def test_other_color_spaces_are_refused(pixels):
    with pytest.raises(pixels.Problem, match="neither RGB nor grayscale"):
        pixels.pixel_size("CMYKA", "U8")
    assert pixels.pixel_size("RGBA", "U16") == 8
