"""What can be checked without GIMP: the package, its Python files and the command lines."""

import ast
import importlib.util
import os
import subprocess
import sys
import time
import zipfile
from pathlib import Path

import pytest

from weftex.cli.arguments import parse_task
from weftex.cli.parser import Parser
from weftex.recipe.declared import options_of

ROOT = Path(__file__).resolve().parents[3]


@pytest.fixture(scope="module")
def package(tmp_path_factory):
    """The folder `weftex` of the unpacked ZIP file."""
    folder = tmp_path_factory.mktemp("gimp")
    build = [sys.executable, str(ROOT / "integrations" / "build.py"), "gimp"]
    subprocess.run([*build, "--output", str(folder)], check=True, timeout=120)
    with zipfile.ZipFile(folder / "weftex_gimp.zip") as archive:
        archive.extractall(folder)
        modes = {one.filename: one.external_attr >> 16 for one in archive.infolist()}
    assert os.name == "nt" or modes["weftex/weftex.py"] & 0o111, "GIMP starts executable files only"
    return folder / "weftex"


def loaded(package, name):
    spec = importlib.util.spec_from_file_location(f"plug_in_{name}", package / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def command(package):
    return loaded(package, "command")


@pytest.fixture(scope="module")
def tiff(package):
    return loaded(package, "tiff")


def test_the_folder_and_the_file_that_gimp_starts_have_one_name(package):
    names = {one.name for one in package.iterdir()}
    assert names == {"weftex.py", "command.py", "tiff.py", "options.json", "README.md", "LICENSE"}
    for path in package.glob("*.py"):
        ast.parse(path.read_text("utf-8"), feature_version=(3, 9))


def accepted(task, words):
    """The recipe of a command line, or an exit with the parser's error."""
    parser = Parser(task)
    count = "+" if task in ("synth", "fuse") else None
    parser.add_argument("materials", nargs=count)
    parser.share("--output", "--preset", "--verbose", "--save-source")
    given = ["a.tif", "b.tif", "--map", "map.tif"] if task == "fuse" else ["a.tif"]
    return parse_task(task, parser, [*given, "-o", "out.tif", *words], options_of(task))[1]


@pytest.mark.parametrize("task", ["synth", "tile", "fill", "fuse"])
def test_every_value_of_a_dialog_is_accepted_by_the_command(command, task):
    for option in command.options_of(task):
        name = option["name"]
        values = {
            "size": [(0, 0), (300, 0), (0, 200), (300, 200)],
            "axes": ["both", "x", "y", "none"][: 3 if option["default"] else 4],
            "bool": ["auto", "yes", "no"],
            "int": [0, 5, 2**31 - 1] if name == "seed" else [0, 5],
            "text": [one if isinstance(one, str) else one[0] for one in option["choices"]],
        }[option["type"]]
        for value in values:
            words = command.words_of(task, {name: value})
            recipe = accepted(task, words)
            if name == "method":
                assert value == "auto" or recipe.method.slug == value
            elif name == "seed":
                assert recipe.seed == value
            elif value == (300, 0):
                assert recipe.options["size"] == (300, 300)
            elif value == 5:
                assert recipe.options[name] == 5
            elif value in ("auto", "none", 0) or value == option["default"]:
                assert words in ([], ["--tileable"])


def test_pictures_are_the_same_for_the_plug_in_and_for_weftex(tiff, tmp_path):
    np = pytest.importorskip("numpy")
    from weftex.io.pictures import read_image, write_image

    draw = np.random.default_rng(1)
    for dtype, bits in ((np.uint8, 8), (np.uint16, 16), (np.float32, 32)):
        for channels in (1, 2, 3, 4):
            for width, height in ((1, 1), (3, 2), (500, 700)):
                pixels = (draw.random((height, width, channels)) * 200).astype(dtype)
                picture = tiff.Picture(width, height, channels, bits, pixels.tobytes())
                tiff.write(tmp_path / "a.tif", picture)
                read = read_image(tmp_path / "a.tif")
                assert read.alpha == (channels in (2, 4)) and read.pixels.dtype == dtype
                assert (read.pixels.reshape(pixels.shape) == pixels).all()
                flat = pixels if channels > 1 else pixels[..., 0]
                write_image(tmp_path / "b.tif", flat, alpha=channels in (2, 4))
                assert tiff.read(tmp_path / "b.tif") == picture
                colors = picture.without_alpha()
                assert (
                    not colors.with_alpha().opaque or colors.with_alpha().without_alpha() == colors
                )
                assert colors.with_alpha().opaque and colors.opaque


@pytest.fixture
def program(tmp_path):
    """Make a program that stands in for the command; it runs lines of Python."""

    def make(*lines):
        path = tmp_path / ("weftex.bat" if os.name == "nt" else "weftex")
        script = tmp_path / "program.py"
        script.write_text("\n".join(("import sys, time", *lines)), "utf-8")
        call = f'"{sys.executable}" "{script}"'
        path.write_text(f"@{call} %*\n" if os.name == "nt" else f'#!/bin/sh\nexec {call} "$@"\n')
        path.chmod(0o755)
        return str(path)

    return make


def test_the_command_is_found_by_setting_path_and_usual_folders(
    command, program, monkeypatch, tmp_path
):
    path = program("print('weftex 0.2.0')")
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("WEFTEX", raising=False)
    assert Path(command.find_command()) == Path(path)
    monkeypatch.setenv("PATH", "")
    monkeypatch.setattr(command, "usual_folders", lambda: [str(tmp_path)])
    assert Path(command.find_command()) == Path(path)
    monkeypatch.setattr(command, "usual_folders", list)
    assert Path(command.find_command(path)) == Path(path)
    with pytest.raises(command.Problem, match="was not found"):
        command.find_command()
    monkeypatch.setenv("WEFTEX", str(tmp_path / "other"))
    with pytest.raises(command.Problem, match=r"\$WEFTEX names .*other"):
        command.find_command(path)


def test_versions_that_do_not_fit_are_refused(command, program):
    command.check_version(program("print('weftex 0.10.0')"))
    with pytest.raises(command.Problem, match="is weftex 0.1.9; this plug-in needs"):
        command.check_version(program("print('weftex 0.1.9')"))
    with pytest.raises(command.Problem, match="does not work: no module"):
        command.check_version(program("sys.exit('no module')"))
    with pytest.raises(command.Problem, match="cannot be started"):
        command.check_version("/nowhere/weftex")


def test_a_run_ends_with_the_commands_own_error_or_when_it_is_canceled(command, program):
    command.run(program("pass"), [], lambda share, stage: True)
    failing = program('sys.exit(\'{"error": "the sample is too small"}\')')
    with pytest.raises(command.Problem, match="^The sample is too small$"):
        command.run(failing, [], lambda share, stage: True)
    start = time.monotonic()
    with pytest.raises(command.Canceled):
        command.run(program("sys.stdin.read()", "sys.exit(129)"), [], lambda share, stage: False)
    assert time.monotonic() - start < 30


def test_failures_of_the_system_are_one_line(command):
    full = command.message_of(OSError(28, "No space left on device"))
    assert full.startswith("No space left on device: ") and command.message_of(MemoryError())
    assert command.message_of(OSError(13, "Permission denied", "/a")) == "Permission denied: /a"
    assert command.message_of(command.Problem("too small")) == "too small"


def test_the_environment_of_the_host_does_not_reach_the_command(command, monkeypatch):
    monkeypatch.setenv("PYTHONHOME", "/host")
    monkeypatch.setenv("APPDIR", "/tmp/.mount_host")
    monkeypatch.setenv("LD_LIBRARY_PATH", "/tmp/.mount_host/lib:/opt/lib")
    given = command.environment()
    assert "PYTHONHOME" not in given and given["LD_LIBRARY_PATH"] == "/opt/lib"
    assert given["PATH"] == os.environ["PATH"]


def test_temporary_folders_go_at_the_end_and_after_a_day(command, monkeypatch, tmp_path):
    monkeypatch.setattr(command.tempfile, "tempdir", str(tmp_path))
    old = tmp_path / "weftex-plug-in-old"
    old.mkdir()
    os.utime(old, (0, 0))
    new = tmp_path / "weftex-plug-in-new"
    new.mkdir()
    with command.Folder() as folder:
        assert folder.is_dir() and not old.exists() and new.exists()
    assert not folder.exists()
