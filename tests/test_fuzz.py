"""What `fuzz/fuzz.py` reads, read here too; and what it and a look at the readers found."""

import importlib.util
import io
import json
import zipfile
from pathlib import Path

import numpy as np
import pytest

import weftex
from families import refused
from weftex.errors import FileError, WeftexError
from weftex.io.manifest import MANIFEST, Manifest
from weftex.naming import parse_method
from weftex.planes.definition import Definition
from weftex.studio.limits import Limits, LruCache
from weftex.studio.sessions import STEPS, Session, Store, key_of

FUZZ = Path(__file__).parent.parent / "fuzz"
DEEP = "[" * 10**5


def tool():
    spec = importlib.util.spec_from_file_location("fuzz", FUZZ / "fuzz.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


fuzz = tool()


@pytest.mark.parametrize("name", fuzz.TARGETS)
def test_corpus(name):
    inputs = sorted((FUZZ / "corpus" / name).iterdir())
    assert inputs
    for file in inputs:
        fuzz.attempt(name, file.read_bytes())
    with zipfile.ZipFile(fuzz.FOUND) as found:
        for one in found.namelist():
            if one.startswith(f"{name}/"):
                fuzz.attempt(name, found.read(one))


def test_corpus_is_small():
    files = [p for p in (FUZZ / "corpus").rglob("*") if p.is_file()]
    assert fuzz.FOUND.stat().st_size < 100_000
    assert len(files) <= 40 and sum(p.stat().st_size for p in files) < 100_000


def test_messages_print_on_one_line():
    for text in ("quilting 'a\nb=1'", "graphcut placemen\x0bt=1", "quil\x1b[31mting", "'\n"):
        with pytest.raises(WeftexError) as info:
            parse_method(text)
        assert str(info.value).isprintable()


def npy(shape, body=b"", dtype="|u1"):
    """An array's header, with whatever follows it."""
    out = io.BytesIO()
    about = {"descr": dtype, "fortran_order": False, "shape": shape}
    np.lib.format.write_array_header_1_0(out, about)
    return out.getvalue() + body


HOSTILE = {
    "less than it says": {"x.npy": npy((2**40,))},
    "below nothing": {"x.npy": npy((-(2**40),))},
    "no array": {"x": b"nothing"},
    "two of one name": {"x.npy": npy((1,), b"1"), "x": bytes(10**6)},
    "one that hides": {"x.npy": npy((1,), b"1"), "x.npy.npy": npy((1,), b"1")},
}


@pytest.mark.parametrize("what", HOSTILE)
def test_arrays_are_what_they_say(tmp_path, what):
    saved, plane = tmp_path / "a.npz", tmp_path / "b.npz"
    result = weftex.synthesize(np.zeros((8, 8), np.uint8), 9, method="quilting", seed=1)
    result.save(saved)
    facts, *_ = (FUZZ / "corpus/plane/plane").read_bytes().partition(fuzz.BETWEEN)
    np.savez(plane, about=np.array(facts.decode()), pixels0=np.zeros((8, 9, 3), np.uint8))
    weftex.Synthesis.load(saved)
    Definition.load(str(plane))
    for file, load in ((saved, weftex.Synthesis.load), (plane, Definition.load)):
        with zipfile.ZipFile(file, "a") as packed:
            for name, body in HOSTILE[what].items():
                packed.writestr(name, body)
        if what != "one that hides":  # which hides nothing: each has its own name
            refused("is damaged|is not a saved", load, str(file), error=FileError)


@pytest.mark.parametrize(
    "change",
    [
        {"about": {"seed": "7"}},
        {"about": {"height": 64.0}},
        {"about": {"wrap": [0, 1]}},
        {"about": {"stems": {"color": "../../etc/a"}}},
        {"facts": {"maps": ["x/../../a"]}},
        *({"role": {field: [{}]}} for field in ("name", "kind", "channels")),
    ],
)
def test_recipes_of_planes_are_checked(tmp_path, change):
    facts, *_ = (FUZZ / "corpus/plane/plane").read_bytes().partition(fuzz.BETWEEN)
    header = json.loads(facts)
    places = header | {"role": header["facts"]["samples"][0]["role"]}
    for name, values in change.items():
        places[name] |= values
    arrays = {f"pixels{k}": np.zeros((8, 9, 3), np.uint8) for k in range(2)}
    header["facts"]["samples"] *= 1 + len(header["facts"]["maps"])
    np.savez(tmp_path / "a.npz", about=np.array(json.dumps(header)), **arrays)
    refused("is damaged", Definition.load, str(tmp_path / "a.npz"), error=FileError)


def test_json_that_is_too_deep_or_something_else(tmp_path):
    name = "0" * 64
    folder = tmp_path / key_of("")
    folder.mkdir()
    (folder / f"{name}.png").touch()
    upload = {"id": name, "suffix": ".png", "bytes": 1}
    for text in (DEEP, "7", "[7]", '{"id": 7}', json.dumps([{"recipe": 7}]), json.dumps(upload)):
        for file in (f"{name}.json", STEPS):
            (folder / file).write_text(text)
        (tmp_path / MANIFEST).write_text(text)
        session = Session(Store(tmp_path, Limits()), LruCache(1), "")
        assert session.steps == [] and session.uploads == {}
        Manifest(str(tmp_path)).sweep()


def test_a_folder_is_let_go_whose_manifest_cannot_be_read(tmp_path):
    (tmp_path / MANIFEST).write_bytes(b"\xff")
    for _ in range(2):  # the second time it was another batch that had the folder
        refused("cannot read", Manifest, str(tmp_path), error=FileError)


def test_half_a_letter_in_a_manifest(tmp_path):
    line = b'{"output": "a.png", "sample": "\\ud83d"}\n'
    (tmp_path / "a.png").touch()
    (tmp_path / MANIFEST).write_bytes(line)
    Manifest(str(tmp_path)).sweep()
    assert (tmp_path / MANIFEST).read_bytes() == line
