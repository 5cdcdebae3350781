"""The plug-in inside gimp-console: pixels, selections and errors, against the command line."""

import json
import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest

import weftex
from weftex.io.pictures import read_image, write_image

GIMP = shutil.which("gimp-console-3.0") or shutil.which("gimp-console-3")
ROOT = Path(__file__).resolve().parents[3]
WEFTEX = Path(sys.executable).with_name("weftex")
pytestmark = pytest.mark.skipif(GIMP is None, reason="gimp-console-3.0 was not found")
PRECISIONS = {
    "U8_NON_LINEAR": np.uint8,
    "U16_NON_LINEAR": np.uint16,
    "U16_LINEAR": np.uint16,
    "FLOAT_NON_LINEAR": np.float32,
    "FLOAT_LINEAR": np.float32,
}
PEBBLES = weftex.read_image("sample:pebbles").pixels[:120, :140, :3]


def converted(pixels, dtype, channels=3):
    """Pixels of the type with 1 to 4 channels; alpha varies."""
    pixels = pixels if channels > 2 else pixels[..., :1]
    if channels in (2, 4):
        alpha = np.full((*pixels.shape[:2], 1), 255, np.uint8)
        alpha[:40] = 90
        pixels = np.concatenate([pixels, alpha], axis=2)
    scale = {"uint8": 1, "uint16": 257, "float32": 1 / 255}[np.dtype(dtype).name]
    return np.ascontiguousarray((pixels * np.float64(scale)).astype(dtype))


class Session:
    """Collects jobs, does all of them in one start of GIMP, and keeps what became of them."""

    def __init__(self, folder):
        self.folder, self.jobs, self.done = folder, [], []

    def layer(self, pixels, name="photo", **more):
        file = f"in-{len(self.jobs)}-{name}.raw"
        (self.folder / file).write_bytes(pixels.tobytes())
        height, width, channels = pixels.shape
        return {"name": name, "file": file, "size": [width, height], "channels": channels, **more}

    def job(self, procedure, layers, precision="U8_NON_LINEAR", base="RGB", size=None, **more):
        first = layers[0] if "size" in layers[0] else layers[0]["layers"][0]
        self.jobs.append({"procedure": procedure, "layers": layers, "precision": precision,
                          "base": base, "size": size or first["size"], **more})  # fmt: skip
        return len(self.jobs) - 1

    def run(self, **variables):
        (self.folder / "jobs.json").write_text(json.dumps(self.jobs), "utf-8")
        script = Path(__file__).with_name("in_gimp.py")
        kept = {name: os.environ[name] for name in ("HOME", "LANG") if name in os.environ}
        # GIMP starts plug-ins with the first python3, which must be the system's, with gi.
        kept["PATH"] = "/usr/local/bin:/usr/bin:/bin"
        answer = subprocess.run(
            [GIMP, "-i", "-d", "--batch-interpreter=python-fu-eval", "-b",
             f"exec(open({str(script)!r}).read())", "--quit"],
            capture_output=True, text=True, timeout=580,
            env={**kept, "GIMP3_DIRECTORY": str(self.folder / "profile"),
                 "WEFTEX_TEST_FOLDER": str(self.folder), "WEFTEX": str(WEFTEX), **variables},
        )  # fmt: skip
        path, failed = self.folder / "done.json", self.folder / "failed.txt"
        assert path.exists(), failed.read_text("utf-8") if failed.exists() else answer.stderr
        self.done = json.loads(path.read_text("utf-8"))
        return self.done

    def pixels(self, layer, dtype, channels):
        width, height = layer["size"]
        flat = np.frombuffer((self.folder / layer["file"]).read_bytes(), dtype)
        return flat.reshape(height, width, channels)


def new_session(folder):
    plug_ins = folder / "profile" / "plug-ins"
    plug_ins.mkdir(parents=True)
    build = [sys.executable, str(ROOT / "integrations" / "build.py"), "gimp"]
    subprocess.run([*build, "--output", str(folder)], check=True, timeout=120)
    with zipfile.ZipFile(folder / "weftex_gimp.zip") as archive:
        archive.extractall(plug_ins)
    (plug_ins / "weftex" / "weftex.py").chmod(0o755)
    return Session(folder)


def by_command(folder, task, pixels, *words, mask=None):
    """What the command line makes of pixels."""
    alpha = pixels.shape[2] in (2, 4)
    write_image(folder / "in.tif", pixels if pixels.shape[2] > 1 else pixels[..., 0], alpha=alpha)
    if mask is not None:
        write_image(folder / "mask.png", mask.astype(np.uint8) * 255)
        words = [*words, "--mask" if task == "fill" else "--sample-mask", str(folder / "mask.png")]
    command = [WEFTEX, task, folder / "in.tif", "-o", folder / "out.tif", *words, "--quiet"]
    subprocess.run([str(one) for one in command], check=True, timeout=300)
    made = read_image(folder / "out.tif").pixels
    return made.reshape(*made.shape[:2], -1)


# Each entry becomes jobs of one session; tests ask for their results by its name.
CASES = {}
for _name, _dtype in PRECISIONS.items():
    for _channels in (1, 2, 3, 4):
        if _channels == 3 or _name in ("U8_NON_LINEAR", "FLOAT_LINEAR"):
            CASES[_name, _channels] = (_dtype, converted(PEBBLES, _dtype, _channels))


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    session = new_session(tmp_path_factory.mktemp("with space ü"))
    numbers = {}
    hole = ["rectangle", 50, 40, 24, 20]
    for (precision, channels), (_, pixels) in CASES.items():
        common = {"precision": precision, "base": "RGB" if channels > 2 else "GRAY"}
        for task, procedure, values, selected in (
            ("synth", "weftex-make-more", {"width": 150, "height": 100, "seed": 7}, []),
            ("tile", "weftex-make-tileable", {"seed": 7}, []),
            ("fill", "weftex-heal-selection", {"seed": 7}, [hole]),
        ):
            numbers[task, precision, channels] = session.job(
                procedure, [session.layer(pixels)], values=values, select=selected, **common
            )
    session.run()
    session.numbers = numbers
    return session


@pytest.mark.parametrize("task", ["synth", "tile", "fill"])
@pytest.mark.parametrize("precision, channels", list(CASES))
def test_pixels_equal_those_of_the_command_line(done, tmp_path, task, precision, channels):
    dtype, pixels = CASES[precision, channels]
    job = done.done[done.numbers[task, precision, channels]]
    assert job["status"] == "success", job["error"]
    words, mask = {"synth": ["--size", "150x100"], "tile": [], "fill": []}[task], None
    if task == "fill":
        mask = np.zeros(pixels.shape[:2], bool)
        mask[40:60, 50:74] = True
    expected = by_command(tmp_path, task, pixels, *words, "--seed", "7", mask=mask)
    image = job["made"] if task == "synth" else job["after"]
    assert len(image["layers"]) == (2 if task == "tile" else 1)
    layer = image["layers"][0]
    assert layer["format"] == job["before"]["layers"][0]["format"]
    made = done.pixels(layer, dtype, channels)
    assert (made == expected).all(), np.abs(made.astype(float) - expected).max()
