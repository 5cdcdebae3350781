"""The plug-in inside Krita, on an X server in memory: pixels, selections, errors, cancel, undo."""

import json
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest

import weftex
from weftex.io.pictures import read_image, write_image

KRITA, XVFB = shutil.which("krita"), shutil.which("xvfb-run")
ROOT = Path(__file__).resolve().parents[3]
WEFTEX = Path(sys.executable).with_name("weftex")
pytestmark = [
    pytest.mark.skipif(KRITA is None, reason="krita was not found"),
    pytest.mark.skipif(XVFB is None, reason="xvfb-run was not found"),
]
PEBBLES = weftex.read_image("sample:pebbles").pixels[:120, :140, :3]
DEPTHS = {"U8": np.uint8, "U16": np.uint16, "F16": np.float16, "F32": np.float32}


def in_krita(pixels, dtype, model):
    """The bytes of opaque pixels in Krita: BGRA for integers, RGBA for floats, gray with alpha."""
    scale = {"uint8": 1, "uint16": 257}.get(np.dtype(dtype).name, 1 / 255)
    colors = (pixels * np.float64(scale)).astype(dtype)
    colors = colors[..., :1] if model == "GRAYA" else colors
    full = np.iinfo(dtype).max if np.dtype(dtype).kind == "u" else 1
    alpha = np.full((*pixels.shape[:2], 1), full, dtype)
    if model == "RGBA" and np.dtype(dtype).kind == "u":
        colors = colors[..., ::-1]
    return np.ascontiguousarray(np.concatenate([colors, alpha], axis=2))


def out_of_krita(pixels):
    """Pixels in the order RGB, and their alpha."""
    order = [2, 1, 0] if pixels.shape[2] == 4 and pixels.dtype.kind == "u" else [0, 1, 2]
    order = [0] if pixels.shape[2] == 2 else order
    return np.ascontiguousarray(pixels[..., order]), pixels[..., -1]


class Session:
    """Collects jobs, does all of them in one start of Krita, and keeps what became of them."""

    def __init__(self, folder):
        self.folder, self.jobs, self.done = folder, [], []

    def job(self, task, pixels, depth="U8", model="RGBA", offset=(0, 0), size=None, **more):
        height, width = pixels.shape[:2]
        own_model, own_depth = more.get("layer space", [model, depth])
        data = pixels
        if pixels.shape[2] == 3:
            data = in_krita(pixels, DEPTHS[own_depth], own_model)
        file = f"in-{len(self.jobs)}.raw"
        (self.folder / file).write_bytes(data.tobytes())
        more.setdefault("values", {"seed": 7})
        self.jobs.append({"task": task, "file": file, "space": [model, depth],
                          "box": [*offset, width, height], "size": size or [width, height],
                          **more})  # fmt: skip
        return len(self.jobs) - 1

    def run(self, **variables):
        (self.folder / "jobs.json").write_text(json.dumps(self.jobs), "utf-8")
        home = self.folder / "home"
        environment = {
            "PATH": "/usr/local/bin:/usr/bin:/bin", "LANG": "C.UTF-8", "HOME": str(home),
            "XDG_DATA_HOME": str(home / ".local" / "share"), "XDG_RUNTIME_DIR": str(home),
            "XDG_CONFIG_HOME": str(home / ".config"),
            "WEFTEX_TEST_FOLDER": str(self.folder), "WEFTEX": str(WEFTEX), **variables,
        }  # fmt: skip
        command = [XVFB, "-a", "-s", "-screen 0 1280x800x24", "env", f"TMPDIR={self.folder}"]
        command += [KRITA, "--nosplash"]
        for _ in range(3):  # xvfb-run does not wait for the X server of a busy machine
            answer = subprocess.run(
                command, capture_output=True, text=True, timeout=550, env=environment
            )
            if "could not connect to display" not in answer.stderr:
                break
        path, failed = self.folder / "done.json", self.folder / "failed.txt"
        assert path.exists(), failed.read_text("utf-8") if failed.exists() else answer.stderr
        self.done = json.loads(path.read_text("utf-8"))
        return self.done

    def pixels(self, layer):
        model, depth, _ = layer["space"]
        data = np.frombuffer((self.folder / layer["file"]).read_bytes(), DEPTHS[depth])
        _, _, width, height = layer["box"]
        return out_of_krita(data.reshape(height, width, 4 if model == "RGBA" else 2))


def new_session(folder):
    """Krita with the plug-in, installed by Krita's own importer, and the one that does the jobs."""
    resources, config = folder / "home" / ".local" / "share" / "krita", folder / "home" / ".config"
    resources.mkdir(parents=True)
    config.mkdir()
    build = [sys.executable, str(ROOT / "integrations" / "build.py"), "krita"]
    subprocess.run([*build, "--output", str(folder)], check=True, timeout=120)
    importers = list(Path("/usr/share/krita/pykrita/plugin_importer").glob("plugin_importer.py"))
    if importers:
        words = [sys.executable, importers[0], folder / "weftex_krita.zip", resources]
        said = subprocess.run(words, check=True, capture_output=True, text=True, timeout=60).stdout
        assert "Imported plugin: weftex" in said
    else:
        with zipfile.ZipFile(folder / "weftex_krita.zip") as archive:
            archive.extractall(resources / "pykrita")
    plug_ins = resources / "pykrita"
    shutil.copytree(Path(__file__).with_name("weftex_tests"), plug_ins / "weftex_tests")
    text = (plug_ins / "weftex_krita.desktop").read_text("utf-8")
    text = text.replace("weftex_krita", "weftex_tests").replace("Name=weftex", "Name=tests")
    (plug_ins / "weftex_tests.desktop").write_text(text, "utf-8")
    enabled = "[python]\nenable_weftex_krita=true\nenable_weftex_tests=true\n"
    (config / "kritarc").write_text(enabled, "utf-8")
    return Session(folder)


def by_command(folder, task, pixels, *words, mask=None):
    """What the command line makes of pixels."""
    pixels = pixels.astype(np.float32) if pixels.dtype == np.float16 else pixels
    write_image(folder / "in.tif", pixels if pixels.shape[2] > 1 else pixels[..., 0])
    if mask is not None:
        write_image(folder / "mask.png", mask.astype(np.uint8) * 255)
        words = [*words, "--mask" if task == "fill" else "--sample-mask", str(folder / "mask.png")]
    command = [WEFTEX, task, folder / "in.tif", *words, "-o", folder / "out.tif", "--quiet"]
    subprocess.run([str(one) for one in command], check=True, timeout=300)
    made = read_image(folder / "out.tif").pixels
    return made.reshape(*made.shape[:2], -1)


SPACES = [("RGBA", depth) for depth in DEPTHS] + [("GRAYA", "U8"), ("GRAYA", "U16")]
HOLE = [50, 40, 24, 20, 255]


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    """All jobs, done in one start of Krita: results by names."""
    session, names = new_session(tmp_path_factory.mktemp("with space ü")), {}

    def add(name, task, pixels=PEBBLES, **more):
        names[name] = session.job(task, pixels, **more)

    for space in SPACES:
        common = {"model": space[0], "depth": space[1]}
        add(("synth", *space), "Make More", values={"size": [150, 100], "seed": 7}, **common)
        add(("tile", *space), "Make Tileable", **common)
        add(("fill", *space), "Heal Selection", select=[HOLE], **common)
    add("other space", "Heal Selection", select=[HOLE], **{"layer space": ["RGBA", "U16"]})
    half = [[50, 40, 24, 20, 255], [74, 40, 10, 20, 100]]
    add("feather", "Heal Selection", select=half)
    add(
        "offset", "Heal Selection", offset=(30, 20), size=[300, 200], select=[[20, 10, 30, 40, 255]]
    )
    add("dot", "Heal Selection", select=[[20, 20, 1, 1, 255]])
    add("part", "Make More", values={"size": [150, 0], "seed": 7}, select=[[10, 20, 100, 90, 255]])
    add("corner", "Make More", values={"size": [150, 0], "seed": 7},
        select=[[10, 5, 120, 60, 255], [10, 5, 60, 110, 255]])  # fmt: skip
    add(
        "tiled part",
        "Make Tileable",
        offset=(30, 20),
        size=[300, 200],
        select=[[50, 50, 90, 80, 255]],
    )
    add("undo heal", "Heal Selection", select=[HOLE], undo=True)
    add("undo tile", "Make Tileable", undo=True)
    add("nothing", "Heal Selection")
    add("everything", "Heal Selection", select=[[0, 0, 140, 120, 255]])
    add("outside", "Make Tileable", size=[300, 200], select=[[200, 150, 9, 9, 255]])
    add("none", "Make Tileable", node=False)
    add("huge", "Make More", values={"size": [200_000, 0]})
    cmyk = np.full((60, 60, 5), 255, np.uint8)
    add("cmyk", "Make Tileable", cmyk, model="CMYKA")
    add("canceled", "Make More", values={"size": [4000, 4000], "seed": 7}, cancel=True)
    session.run()
    return {name: session.done[number] for name, number in names.items()} | {"session": session}


def made_by(done, name):
    """The pixels and alpha of what a job made."""
    job = done[name]
    assert not job["error"], job["error"]
    layers = job["made"]["layers"] if "made" in job else job["after"]["layers"]
    return done["session"].pixels(layers[-1])


@pytest.mark.parametrize("model, depth", SPACES)
@pytest.mark.parametrize("task", ["synth", "tile", "fill"])
def test_pixels_equal_those_of_the_command_line(done, tmp_path, task, model, depth):
    job = done[task, model, depth]
    made, alpha = made_by(done, (task, model, depth))
    photo, _ = done["session"].pixels(job["before"]["layers"][0])
    words, mask = {"synth": ["--size", "150x100"], "tile": [], "fill": []}[task], None
    if task == "fill":
        mask = np.zeros(photo.shape[:2], bool)
        mask[40:60, 50:74] = True
    expected = by_command(tmp_path, task, photo, *words, "--seed", "7", mask=mask)
    layer = (job["made"] if task == "synth" else job["after"])["layers"][-1]
    assert layer["space"] == job["before"]["layers"][0]["space"]
    if task == "fill":
        x, y, width, height = layer["box"]
        assert x <= 50 and y <= 40 and x + width >= 74 and y + height >= 60
        inside = np.s_[40 - y : 60 - y, 50 - x : 74 - x]
        outside = np.ones(alpha.shape, bool)
        outside[inside] = False
        assert not alpha[outside].any()
        made, alpha, expected = made[inside], alpha[inside], expected[40:60, 50:74]
    assert (alpha == alpha.flat[0]).all() and alpha.flat[0] > 0
    assert (made == expected.astype(made.dtype)).all()


@pytest.mark.parametrize("name", ["undo heal", "undo tile", "feather", "offset", "dot"])
def test_the_photo_stays_as_it_is(done, name):
    job, folder = done[name], done["session"].folder
    assert not job["error"], job["error"]
    before, after = job["before"]["layers"][0], job["after"]["layers"][0]
    assert before["name"] == after["name"]
    assert (folder / before["file"]).read_bytes() == (folder / after["file"]).read_bytes()


def test_a_layer_keeps_its_own_color_space(done, tmp_path):
    made, _ = made_by(done, "other space")
    space = ["RGBA", "U16", "sRGB-elle-V2-g10.icc"]
    assert [one["space"] for one in done["other space"]["after"]["layers"]] == [space, space]
    mask = np.zeros(PEBBLES.shape[:2], bool)
    mask[40:60, 50:74] = True
    expected = by_command(tmp_path, "fill", PEBBLES * np.uint16(257), "--seed", "7", mask=mask)
    x, y = done["other space"]["after"]["layers"][-1]["box"][:2]
    assert (made[40 - y : 60 - y, 50 - x : 74 - x] == expected[40:60, 50:74]).all()


def test_partly_selected_pixels_are_partly_covered(done):
    _, alpha = made_by(done, "feather")
    x, y = done["feather"]["after"]["layers"][-1]["box"][:2]
    assert (alpha[40 - y : 60 - y, 50 - x : 74 - x] == 255).all()
    assert (alpha[40 - y : 60 - y, 74 - x : 84 - x] == 100).all()


def test_undo_removes_the_new_layer(done):
    for name in ("undo heal", "undo tile"):
        assert len(done[name]["after"]["layers"]) == 2
        assert [one["name"] for one in done[name]["undone"]["layers"]] == ["photo"]


def test_the_sample_is_the_selected_part(done, tmp_path):
    words = ["--size", "150", "--seed", "7"]
    made, _ = made_by(done, "part")
    crop = np.ascontiguousarray(PEBBLES[20:110, 10:110])
    assert (made == by_command(tmp_path, "synth", crop, *words)).all()
    made, _ = made_by(done, "corner")
    mask = np.ones((110, 120), bool)
    mask[60:, 60:] = False
    crop = np.ascontiguousarray(PEBBLES[5:115, 10:130])
    assert (made == by_command(tmp_path, "synth", crop, *words, mask=mask)).all()


def test_a_tileable_part_is_a_layer_at_its_place(done, tmp_path):
    made, alpha = made_by(done, "tiled part")
    x, y = done["tiled part"]["after"]["layers"][-1]["box"][:2]
    crop = np.ascontiguousarray(PEBBLES[30:110, 20:110])
    expected = by_command(tmp_path, "tile", crop, "--seed", "7")
    inside = np.s_[50 - y : 130 - y, 50 - x : 140 - x]
    assert (made[inside] == expected).all() and alpha[inside].all()


@pytest.mark.parametrize("name, said", [
    ("nothing", "Nothing is selected: select what to replace"),
    ("everything", "nothing"),
    ("outside", "The selection is outside the layer"),
    ("none", "Open an image and select a layer"),
    ("huge", "too many; the limit is 268 megapixels"),
    ("cmyk", "neither RGB nor grayscale"),
])  # fmt: skip
def test_errors_say_what_to_do_and_change_nothing(done, name, said):
    job = done[name]
    assert said in job["error"] and len(job["after"]["layers"]) == 1


def test_a_canceled_run_leaves_nothing(done):
    job = done["canceled"]
    assert job["over"] and not job["error"] and not job["left"]
    assert "made" not in job and len(job["after"]["layers"]) == 1


def test_krita_works_on_while_the_command_runs(done):
    assert done["canceled"]["events meanwhile"] > 5


def test_a_missing_command_is_named(tmp_path):
    session = new_session(tmp_path)
    session.job("Make Tileable", PEBBLES)
    (job,) = session.run(WEFTEX="/nowhere/weftex")
    assert "$WEFTEX names /nowhere/weftex, which is not a program" in job["error"]
