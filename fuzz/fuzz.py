"""Any bytes are read, or refused in one line: the readers of weftex, fed by a fuzzer.

    pip install atheris
    python fuzz/fuzz.py saved --seconds 300     one reader; what it finds is left in build/fuzz
    python fuzz/fuzz.py saved FILE ...          some inputs again
    python fuzz/fuzz.py --seeds                 write the corpus anew
    python fuzz/fuzz.py --keep                  pack what reached new lines, to go on from it

The suite reads `fuzz/corpus` and `fuzz/found.zip` with the same functions, without atheris. Inputs
of `saved` and `plane` are the parts of an `.npz` file, so that the fuzzer need not learn to zip.
"""

from __future__ import annotations

import argparse
import io
import json
import sys
import tempfile
import tracemalloc
import zipfile
import zlib
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from unittest import mock

HERE = Path(__file__).resolve().parent
CORPUS = HERE / "corpus"
FOUND, LEFT = (
    HERE / "found.zip",
    HERE.parent / "build" / "fuzz",
)  # what the fuzzer keeps, and packed
BETWEEN = b"\n--\n"  # parts of an input; the first is JSON, of the others the first line is a name
_MOST = 2**26  # bytes of memory: inputs are small, and so are the pictures that they may claim
_PIXELS = 2**16


def picture(data: bytes, folder: Path) -> None:
    """A picture, as a sample and as a label map."""
    import weftex
    from weftex.io.pictures import read_image
    from weftex.label_maps import labels_of

    file = folder / "picture"
    file.write_bytes(_mended(data))
    pixels = read_image(file, max_pixels=_PIXELS).pixels
    for read in (lambda: weftex.Exemplar(pixels), lambda: labels_of(pixels, 2)):
        try:
            read()
        except weftex.WeftexError as error:
            check_line(error)


def saved(data: bytes, folder: Path) -> None:
    """A saved result, and all that is done with one."""
    import numpy as np

    import weftex
    from weftex.results import saved as stored

    with mock.patch.object(stored, "MAX_PIXELS", _PIXELS):
        result = weftex.Synthesis.load(_packed(data, folder))
    if max(result.sample_shape[0] * result.sample_shape[1], *result.shape) > 2**12:
        return
    sample = np.arange(result.sample_shape[0] * result.sample_shape[1], dtype=np.uint16)
    result = weftex.Synthesis.load(
        folder / "made.npz", weftex.Exemplar(sample.reshape(result.sample_shape))
    )
    for ask in (lambda: result.image, lambda: result.source, result.draw):
        try:
            ask()
        except weftex.WeftexError as error:
            check_line(error)


def plane(data: bytes, folder: Path) -> None:
    """The recipe of a plane on disk."""
    from weftex.planes.definition import Definition

    recipe = Definition.load(str(_packed(data, folder)))
    assert recipe.about and recipe.layouts


def journal(data: bytes, folder: Path) -> None:
    """What a plane's journal and its record of a run say."""
    from weftex.planes.record import Record

    run = folder / "plane.tif.run"
    run.mkdir(exist_ok=True)
    (run / "run.json").write_bytes(data)
    (run / "done.txt").write_bytes(data)
    record = Record(str(folder / "plane.tif"), run="a" * 32)
    record.done()
    record.current()


def manifest(data: bytes, folder: Path) -> None:
    """A batch's manifest."""
    from weftex.io.manifest import Manifest

    (folder / "manifest.jsonl").write_bytes(data)
    (folder / "a.png").touch()
    held = Manifest(str(folder))
    held.sweep()


def studio(data: bytes, folder: Path) -> None:
    """A recipe that a page sends, and what a session has on disk."""
    from weftex.errors import InvalidInputError
    from weftex.recipe import Recipe
    from weftex.studio.limits import Limits, LruCache
    from weftex.studio.sessions import Session, Store, key_of

    own = folder / key_of("")
    own.mkdir(exist_ok=True)
    for name in ("kept.json", "0" * 64 + ".json"):
        (own / name).write_bytes(data)
    (own / ("0" * 64 + ".png")).touch()
    Session(Store(folder, Limits()), LruCache(1), "")
    try:
        given = json.loads(data)
    except (ValueError, RecursionError):  # which the server refuses before, as it does what is deep
        return
    try:
        recipe = Recipe.from_json(given)
        assert Recipe.from_json(recipe.as_json()) == recipe and recipe.pictures is not None
    except InvalidInputError as error:
        check_line(error)


def method(data: bytes, folder: Path) -> None:
    """A method's text."""
    from weftex.naming import parse_method, text_of

    found = parse_method(data.decode("utf-8", "surrogateescape"))
    assert parse_method(text_of(found)) == found


def preset(data: bytes, folder: Path) -> None:
    """A preset of a user."""
    from weftex.io.presets import read_preset

    file = folder / "mine.toml"
    file.write_bytes(data)
    read_preset(file)


TARGETS: dict[str, Callable[[bytes, Path], None]] = {
    one.__name__: one for one in (picture, saved, plane, journal, manifest, studio, method, preset)
}


def attempt(name: str, data: bytes) -> None:
    """Read an input; whatever is raised from here is a mistake of weftex."""
    from weftex.errors import WeftexError

    with tempfile.TemporaryDirectory() as folder:
        tracemalloc.start()
        try:
            TARGETS[name](data, Path(folder))
        except WeftexError as error:
            check_line(error)
        finally:
            peak = tracemalloc.get_traced_memory()[1]
            tracemalloc.stop()
        assert peak < _MOST, f"{peak >> 20} MiB for {len(data)} bytes"


def check_line(error: Exception) -> None:
    """A message is one line that prints."""
    assert str(error) and len(str(error).splitlines()) == 1, repr(str(error))


def _mended(data: bytes) -> bytes:
    """A PNG with the check sums of its chunks set right, for no change would go deeper."""
    place = 8
    while data.startswith(b"\x89PNG\r\n\x1a\n") and place + 12 <= len(data):
        end = place + 8 + int.from_bytes(data[place : place + 4], "big")
        if end + 4 > len(data):
            break
        data = data[:end] + zlib.crc32(data[place + 4 : end]).to_bytes(4, "big") + data[end + 4 :]
        place = end + 4
    return data


def _packed(data: bytes, folder: Path) -> Path:
    """The `.npz` file of these parts."""
    import numpy as np

    facts, *arrays = data.split(BETWEEN)
    about = io.BytesIO()
    np.save(about, np.array(facts.decode("utf-8", "replace")))
    path = folder / "made.npz"
    with zipfile.ZipFile(path, "w") as file:
        file.writestr("about.npy", about.getvalue())
        for one in arrays:
            name, _, body = one.partition(b"\n")
            if name.isascii() and name.decode().isprintable() and name:
                file.writestr(name.decode(), body)
    return path


def unpacked(path: Path) -> bytes:
    """The parts of an `.npz` file, as an input has them."""
    import numpy as np

    with zipfile.ZipFile(path) as file, np.load(path) as arrays:
        names = [name for name in file.namelist() if name != "about.npy"]
        parts = [name.encode() + b"\n" + file.read(name) for name in names]
        return BETWEEN.join([str(arrays["about"]).encode(), *parts])


def seeds() -> dict[str, dict[str, bytes]]:
    """Small inputs of every kind."""
    import numpy as np

    import weftex
    from weftex.io.pictures import write_image
    from weftex.planes.definition import define

    pixels = np.arange(8 * 9 * 3, dtype=np.uint8).reshape(8, 9, 3)
    found: dict[str, dict[str, bytes]] = {name: {} for name in TARGETS}
    with tempfile.TemporaryDirectory() as folder:
        for kind in ("png", "jpg", "tif", "webp", "bmp", "exr"):
            floats = kind == "exr"
            file = Path(folder, f"a.{kind}")
            write_image(file, pixels[:4, :4].astype(np.float32) if floats else pixels)
            found["picture"][kind] = file.read_bytes()
        file = Path(folder, "a.npz")
        for slug in ("patch-sampling", "quilting", "efros-leung"):
            weftex.synthesize(pixels, 12, method=slug, seed=1).save(file)
            found["saved"][slug] = unpacked(file)
        hole = np.indices((8, 9)).sum(0) == 8
        weftex.fill(pixels, hole, method="wei-levoy", seed=1).save(file)
        found["saved"]["hole"] = unpacked(file)
        define(pixels, 64, weftex.PatchSampling(patch_size=5), {}, seed=1).save(str(file))
        found["plane"]["plane"] = unpacked(file)
    line = f"{'a' * 32} 0 0 1 123 456"
    found["journal"] = {
        "blocks": f"\n{line} {zlib.crc32(line.encode()):08x}\n{line[:40]}".encode(),
        "run": b'{"name": "a", "begun": true, "files": ["plane.tif"], "about": {"seed": 1}}',
    }
    found["manifest"] = {
        "lines": b'{"output": "a.png", "seed": 1}\n{"output": "b.png"}\n[1]\n{"outp',
        "letters": '{"output": "\u00e4.png", "sample": "x"}\n'.encode(),
    }
    recipes = {
        "synth": {"materials": [{"sample": "bricks"}], "seed": 7, "size": [64, 64], "best_of": 2},
        "tile": {"task": "tile", "materials": [{"maps": {"a b": "x"}, "turn": "4"}], "axes": "x"},
        "fill": {"task": "fill", "materials": [{"sample": "hole", "even_light": 0.5}],
                 "method": "quilting", "parameters": {"patch_size": 9}, "mask": "alpha"},
        "fuse": {"task": "fuse", "materials": [{"sample": "grass"}, {"sample": "wood"}],
                 "map": {"direction": "up", "width": 0.5, "center": [0.5, 0.5]}},
        "upload": {"id": "0" * 64, "suffix": ".png", "bytes": 1, "name": "a"},
        "kept": [{"recipe": {"task": "synth"}, "name": "one"}],
    }  # fmt: skip
    found["studio"] = {name: json.dumps(one).encode() for name, one in recipes.items()}
    texts = ("auto", "graphcut placement=entire tolerance=0.5", "quilting 'patch_size=9'")
    found["method"] = {text.split()[0]: text.encode() for text in texts}
    found["preset"] = {
        "packed": b'bits = 8\n[missing]\nao = 1\n[[file]]\nname = "{name}_a"\nformat = "png"\n'
        b'channels = ["ao", "roughness", "opacity?"]',
        "names": b'about = "x"\nothers = "{name}-{Role}"\n[[file]]\nname = "{name}-c"\n'
        b'channels = ["color"]',
    }
    # And what was once a mistake.
    found["saved"]["hidden"] = found["saved"]["efros-leung"] + BETWEEN + b"x\nno array"
    stems = b'"stems": {', b'"stems": {"color": "../a"'
    found["plane"]["elsewhere"] = found["plane"]["plane"].replace(*stems)
    found["journal"]["list"] = b"[7]"
    found["manifest"]["bytes"] = b'{"output": "\xff"}\n'
    found["manifest"]["half"] = b'{"output": "a.png", "sample": "\\ud83d"}\n'
    found["studio"]["other"] = b'[{"recipe": 7}, 7]'
    found["preset"]["deep"] = b"a = " + b"[" * 5000
    found["method"]["control"] = b"graphcut placemen\x0bt=1"
    return found


def fuzz(name: str, seconds: int) -> None:
    """Change inputs for so long, and go on with those that reach new lines of weftex."""
    import atheris

    with atheris.instrument_imports(include=["weftex"], enable_loader_override=False):
        for one in ("weftex", "weftex.label_maps", "weftex.planes.definition", "weftex.naming",
                    "weftex.io.manifest", "weftex.planes.record",
                    "weftex.recipe", "weftex.studio.sessions"):  # fmt: skip
            import_module(one)
    left = LEFT / name
    left.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(FOUND) as packed:
        packed.extractall(LEFT, [one for one in packed.namelist() if one.startswith(f"{name}/")])
    options = [f"-max_total_time={seconds}", "-timeout=10", "-rss_limit_mb=2048", "-max_len=8192"]
    options += [f"-artifact_prefix={left}/", "-print_final_stats=1", str(left), str(CORPUS / name)]
    atheris.Setup([sys.argv[0], *options], lambda data: attempt(name, data))
    atheris.Fuzz()


def keep() -> None:
    """Pack what the fuzzer left, but for what went wrong."""
    inputs = [file for name in TARGETS for file in sorted((LEFT / name).glob("[0-9a-f]" * 40))]
    with zipfile.ZipFile(FOUND, "w", zipfile.ZIP_DEFLATED) as packed:
        for file in inputs:
            about = zipfile.ZipInfo(f"{file.parent.name}/{file.name}")  # of no day
            packed.writestr(about, file.read_bytes(), zipfile.ZIP_DEFLATED)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("target", nargs="?", choices=TARGETS)
    parser.add_argument("files", nargs="*", type=Path)
    parser.add_argument("--seconds", type=int, default=300)
    parser.add_argument("--seeds", action="store_true", help="write the corpus anew")
    parser.add_argument("--keep", action="store_true", help="pack what reached new lines")
    args = parser.parse_args()
    if args.keep:
        keep()
    elif args.seeds:
        for name, inputs in seeds().items():
            (CORPUS / name).mkdir(parents=True, exist_ok=True)
            for one, data in inputs.items():
                (CORPUS / name / one).write_bytes(data)
    elif args.target is None:
        parser.error("name a reader, --seeds or --keep")
    elif args.files:
        for file in args.files:
            attempt(args.target, file.read_bytes())
    else:
        fuzz(args.target, args.seconds)


if __name__ == "__main__":
    main()
