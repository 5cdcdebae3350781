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
                 "WEFTEX_TEST_FOLDER": str(self.folder), "WEFTEX": str(WEFTEX),
             "TMPDIR": str(self.folder), **variables},
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
    command = [WEFTEX, task, folder / "in.tif", *words, "-o", folder / "out.tif", "--quiet"]
    subprocess.run([str(one) for one in command], check=True, timeout=300)
    made = read_image(folder / "out.tif").pixels
    return made.reshape(*made.shape[:2], -1)


# (precision, channels): the pixels of a layer
CASES = {}
for _name, _dtype in PRECISIONS.items():
    for _channels in (1, 2, 3, 4):
        if _channels == 3 or _name in ("U8_NON_LINEAR", "FLOAT_LINEAR"):
            CASES[_name, _channels] = converted(PEBBLES, _dtype, _channels)
HOLE = ["rectangle", 50, 40, 24, 20]
MORE, TILE, HEAL, FUSE = (
    f"weftex-{name}" for name in ("make-more", "make-tileable", "heal-selection", "fuse-groups")
)


def common(precision, channels):
    return {"precision": precision, "base": "RGB" if channels > 2 else "GRAY"}


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    """All jobs, done in one start of GIMP: results by names."""
    session = new_session(tmp_path_factory.mktemp("with space ü"))
    layer, names = session.layer, {}

    def add(name, procedure, layers, **more):
        more.setdefault("values", {"seed": 7})
        names[name] = session.job(procedure, layers, **more)

    for case, pixels in CASES.items():
        space = common(*case)
        size = {"width": 150, "height": 100, "seed": 7}
        add(("synth", *case), MORE, [layer(pixels)], values=size, **space)
        add(("tile", *case), TILE, [layer(pixels)], **space)
        add(("fill", *case), HEAL, [layer(pixels)], select=[HOLE], **space)
    photo = PEBBLES
    ellipse, dot = ["ellipse", 50, 40, 30, 24], ["rectangle", 20, 20, 1, 1]
    for precision in PRECISIONS:
        pixels, space = CASES[precision, 3], common(precision, 3)
        add(("ellipse", precision), HEAL, [layer(pixels)], select=[ellipse], **space)
        add(
            ("feather", precision), HEAL, [layer(pixels)], select=[ellipse, ["feather", 9]], **space
        )
    for precision, dtype in (
        ("HALF_LINEAR", np.float16), ("DOUBLE_LINEAR", np.float64), ("U32_NON_LINEAR", np.uint32)
    ):  # fmt: skip
        pixels = (photo / 255 * (2**32 - 1 if dtype == np.uint32 else 1)).astype(dtype)
        add(("other", precision), HEAL, [layer(pixels)], precision=precision, select=[ellipse])
    add("offset", HEAL, [layer(photo, offset=[30, 20])], size=[300, 200],
        select=[["rectangle", 20, 10, 30, 40]])  # fmt: skip
    add("dot", HEAL, [layer(photo)], select=[dot])
    add("mask kept", HEAL, [layer(photo, mask=True)], select=[HOLE])
    add("mask edited", TILE, [layer(photo, mask=True)], edit="mask")
    add("nothing", HEAL, [layer(photo)])
    add("everything", HEAL, [layer(photo)], select=[["rectangle", 0, 0, 140, 120]])
    add("outside", HEAL, [layer(photo)], size=[300, 200], select=[["rectangle", 200, 150, 9, 9]])
    add("locked", HEAL, [layer(photo, locked=True)], select=[HOLE])
    add("indexed", MORE, [layer(photo)], indexed=True)
    add("several", TILE, [layer(photo), layer(photo, "b")], drawables=["photo", "b"])
    add("none", TILE, [layer(photo)], drawables=[])
    add("huge", MORE, [layer(photo)], values={"width": 262_144})
    add("dot sample", MORE, [layer(photo)], select=[dot])
    part = ["rectangle", 10, 20, 100, 90]
    add("part", MORE, [layer(photo)], values={"width": 150, "seed": 7}, select=[part])
    add("corner", MORE, [layer(photo)], values={"width": 150, "seed": 7},
        select=[["rectangle", 10, 5, 120, 60], ["add", 10, 5, 60, 110]])  # fmt: skip
    add("adobe", MORE, [layer(photo)], values={"width": 150, "seed": 7}, profile="adobe")
    add("tiled part", TILE, [layer(photo, offset=[30, 20])], size=[300, 200],
        select=[["rectangle", 50, 50, 90, 80]])  # fmt: skip
    add("in a group", TILE, [{"name": "group", "layers": [layer(photo)]}], drawables=["group"])
    add("group", HEAL, [{"name": "group", "layers": [layer(photo)]}], select=[HOLE])
    sand = np.ascontiguousarray(photo[::-1] // 2)
    paint = np.zeros((160, 200, 4), np.uint8)
    paint[30:, 90:] = 255
    fused = [{"name": "dark", "layers": [layer(paint, "mask"), layer(sand, "dark sample")]},
             {"name": "light", "layers": [layer(photo, "light sample")]}]  # fmt: skip
    add("fused", FUSE, fused, size=[200, 160], drawables=[])
    add("fused two", FUSE, fused, size=[200, 160], drawables=["dark", "light"])
    empty = layer(np.zeros_like(paint), "empty mask")
    add("fused empty", FUSE, [{"name": "dark", "layers": [empty, layer(sand, "sample")]}, fused[1]],
        size=[200, 160], drawables=[])  # fmt: skip
    add("fused one", FUSE, fused[1:], size=[200, 160], drawables=[])
    add("fused unmasked", FUSE, [fused[1], fused[0]], size=[200, 160], drawables=[])
    session.run()
    return {name: session.done[number] for name, number in names.items()} | {"session": session}


def first_pixels(done, image, dtype=np.uint8, channels=3):
    return done["session"].pixels(image["layers"][0], dtype, channels)


@pytest.mark.parametrize("task", ["synth", "tile", "fill"])
@pytest.mark.parametrize("precision, channels", list(CASES))
def test_pixels_equal_those_of_the_command_line(done, tmp_path, task, precision, channels):
    pixels, job = CASES[precision, channels], done[task, precision, channels]
    assert job["status"] == "success", job["error"]
    words, mask = {"synth": ["--size", "150x100"], "tile": [], "fill": []}[task], None
    if task == "fill":
        mask = np.zeros(pixels.shape[:2], bool)
        mask[40:60, 50:74] = True
    expected = by_command(tmp_path, task, pixels, *words, "--seed", "7", mask=mask)
    image = job["made"] if task == "synth" else job["after"]
    assert len(image["layers"]) == (2 if task == "tile" else 1)
    assert image["layers"][0]["format"] == job["before"]["layers"][0]["format"]
    made = first_pixels(done, image, pixels.dtype, channels)
    if task == "fill" and pixels.dtype == np.float32:  # GIMP mixes, and rounds, where selected
        assert (made[~mask] == expected[~mask]).all()
        assert np.allclose(made, expected, rtol=0, atol=1e-6)
    else:
        assert (made == expected).all()


@pytest.mark.parametrize("precision", list(PRECISIONS))
@pytest.mark.parametrize("edge", ["ellipse", "feather"])
def test_the_photo_outside_the_selection_stays_as_it_is(done, precision, edge):
    job, before = done[edge, precision], CASES[precision, 3]
    assert job["status"] == "success", job["error"]
    after = first_pixels(done, job["after"], before.dtype)
    y, x = np.mgrid[:120, :140]
    radius = np.hypot((x + 0.5 - 65) / 15, (y + 0.5 - 52) / 12)
    far = radius > (1.1 if edge == "ellipse" else 2.2)
    assert (after[far] == before[far]).all()
    changed = (after != before).any(axis=2)
    assert changed[radius < 0.5].mean() > 0.9
    bounds = np.abs(x + 0.5 - 65) < 14, np.abs(y + 0.5 - 52) < 11
    assert edge == "feather" or not changed[bounds[0] & bounds[1] & far].any()


@pytest.mark.parametrize("precision", ["HALF_LINEAR", "DOUBLE_LINEAR", "U32_NON_LINEAR"])
def test_other_precisions_are_healed_and_stay_as_they_are_outside(done, precision):
    job = done["other", precision]
    assert job["status"] == "success", job["error"]
    dtype = {"H": np.float16, "D": np.float64, "U": np.uint32}[precision[0]]
    before, after = (first_pixels(done, job[when], dtype) for when in ("before", "after"))
    changed = (before != after).any(axis=2)
    assert changed[46:58, 58:72].all()
    assert not changed[:40].any() and not changed[64:].any() and not changed[40:42, 50:54].any()


def test_a_layer_may_be_smaller_than_the_image_and_elsewhere(done, tmp_path):
    job = done["offset"]
    assert job["status"] == "success" and job["after"]["layers"][0]["offset"] == [30, 20]
    mask = np.zeros((120, 140), bool)
    mask[:30, :20] = True
    expected = by_command(tmp_path, "fill", PEBBLES, "--seed", "7", mask=mask)
    assert (first_pixels(done, job["after"]) == expected).all()


def test_one_selected_pixel_is_healed_alone(done):
    assert done["dot"]["status"] == "success", done["dot"]["error"]
    changed = (first_pixels(done, done["dot"]["after"]) != PEBBLES).any(axis=2)
    changed[20, 20] = False
    assert not changed.any()


def test_a_layer_with_a_mask_is_healed_itself(done):
    assert done["mask kept"]["status"] == "success"
    assert (
        first_pixels(done, done["mask kept"]["after"])[45:55, 55:70] != PEBBLES[45:55, 55:70]
    ).any()


@pytest.mark.parametrize("name, said", [
    ("mask edited", "Select a layer, not a mask or a channel"),
    ("nothing", "Nothing is selected: select what to replace"),
    ("everything", "nothing"),
    ("outside", "The selection is outside the layer"),
    ("locked", "The pixels of this layer are locked"),
    ("indexed", "The image has indexed colors"),
    ("several", "Select one layer"),
    ("none", "Select one layer"),
    ("huge", "too many; the limit is 268 megapixels"),
    ("group", "A layer group has no pixels of its own"),
    ("fused empty", "The mask layer of dark covers nothing"),
    ("fused one", "Two or more layer groups are needed"),
    ("fused unmasked", "The layer group light needs two layers"),
])  # fmt: skip
def test_errors_say_what_to_do_and_change_nothing(done, name, said):
    job = done[name]
    assert job["status"] != "success" and said in job["error"], job["error"]
    for before, after in zip(job["before"]["layers"], job["after"]["layers"], strict=True):
        folder = done["session"].folder
        assert (folder / before["file"]).read_bytes() == (folder / after["file"]).read_bytes()


def test_the_sample_is_the_selected_part(done, tmp_path):
    words = ["--size", "150", "--seed", "7"]
    expected = by_command(tmp_path, "synth", np.ascontiguousarray(PEBBLES[20:110, 10:110]), *words)
    assert (first_pixels(done, done["part"]["made"]) == expected).all()
    assert done["corner"]["status"] == "success", done["corner"]["error"]
    mask = np.ones((110, 120), bool)
    mask[60:, 60:] = False
    crop = np.ascontiguousarray(PEBBLES[5:115, 10:130])
    expected = by_command(tmp_path, "synth", crop, *words, mask=mask)
    assert (first_pixels(done, done["corner"]["made"]) == expected).all()
    dot = first_pixels(done, done["dot sample"]["made"])
    assert (dot == PEBBLES[20, 20]).all()


def test_a_color_profile_is_kept_and_its_values_are_not_converted(done, tmp_path):
    made = done["adobe"]["made"]
    assert "Adobe" in made["profile"] or "RGB" in made["profile"]
    expected = by_command(tmp_path, "synth", PEBBLES, "--size", "150", "--seed", "7")
    assert (first_pixels(done, made) == expected).all()


def test_a_tileable_part_is_a_layer_at_its_place(done, tmp_path):
    layer = done["tiled part"]["after"]["layers"][0]
    assert layer["offset"] == [50, 50] and layer["size"] == [90, 80]
    crop = np.ascontiguousarray(PEBBLES[30:110, 20:110])
    expected = by_command(tmp_path, "tile", crop, "--seed", "7")
    assert (first_pixels(done, done["tiled part"]["after"]) == expected).all()
    assert done["in a group"]["after"]["layers"][0]["name"] == "group tileable"


@pytest.mark.parametrize("name", ["fused", "fused two"])
def test_groups_are_fused_where_masks_are_painted(done, tmp_path, name):
    job = done[name]
    assert job["status"] == "success", job["error"]
    assert job["after"]["layers"][0]["name"] == "fused"
    assert job["after"]["layers"][0]["size"] == [200, 160]
    label = np.zeros((160, 200), np.uint8)
    label[30:, 90:] = 1
    write_image(tmp_path / "map.tif", label)
    write_image(tmp_path / "dark.tif", np.ascontiguousarray(PEBBLES[::-1] // 2))
    words = [tmp_path / "dark.tif", "--map", tmp_path / "map.tif", "--colors", "0,1", "--seed", "7"]
    expected = by_command(tmp_path, "fuse", PEBBLES, *words)
    assert (first_pixels(done, job["after"]) == expected).all()


def test_a_missing_command_is_named(tmp_path):
    session = new_session(tmp_path)
    session.job(TILE, [session.layer(PEBBLES)])
    (job,) = session.run(WEFTEX="/nowhere/weftex")
    assert "$WEFTEX names /nowhere/weftex, which is not a program" in job["error"]
    (tmp_path / "profile" / "weftex-command.txt").write_text(str(WEFTEX) + "\n", "utf-8")
    (job,) = session.run(WEFTEX="")
    assert job["status"] == "success", job["error"]
