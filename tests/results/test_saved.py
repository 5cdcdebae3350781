"""Results in files: saved, loaded, damaged."""

import json
import subprocess
import sys

import numpy as np
import pytest

import weftex
from laid import filled, make
from weftex.errors import FileError, InvalidInputError


@pytest.mark.parametrize("make_one", [make, lambda: make("cut", (True, False)), filled])
def test_saved_and_loaded(tmp_path, make_one):
    result = make_one()
    path = tmp_path / "result.npz"
    result.save(path)
    known = result.canvas.known
    loaded = weftex.Synthesis.load(path, exemplar=result.exemplar, known=known)
    assert np.array_equal(loaded.image, result.image)
    assert np.array_equal(loaded.source, result.source)
    assert loaded.canvas.wrap == result.canvas.wrap and loaded.shape == result.shape
    assert loaded.provenance == result.provenance
    assert loaded.provenance["method"] == "patch-sampling" and "seed" in loaded.provenance
    again = tmp_path / "again.npz"
    loaded.save(again)
    assert again.stat().st_size == pytest.approx(path.stat().st_size, abs=64)
    alone = weftex.Synthesis.load(path)
    normals = np.arange(60 * 68, dtype=np.float32).reshape(60, 68)
    assert np.array_equal(alone.render(normals), result.render(normals))
    for ask in (lambda: alone.image, lambda: alone.maps, alone.draw, alone.render):
        if ask == alone.draw:
            assert np.array_equal(alone.draw(), result.draw())
            continue
        with pytest.raises(InvalidInputError, match="without its sample"):
            ask()


def test_a_saved_result_is_small(tmp_path):
    result = weftex.synthesize("sample:pebbles", (1024, 1024), method="patch-sampling", seed=1)
    result.save(tmp_path / "wall.npz")
    assert (tmp_path / "wall.npz").stat().st_size < result.image.nbytes / 50


def damage(path, **changes):
    with np.load(path) as file:
        arrays = dict(file)
    about = json.loads(str(arrays["about"]))
    for key, value in changes.items():
        if key in arrays:
            arrays[key] = value(arrays[key])
        else:
            about[key] = value(about.get(key))
    arrays["about"] = np.array(json.dumps(about))
    np.savez(path, **arrays)


def put(index, value):
    def change(array):
        array = array.copy()
        array[index] = value
        return array

    return change


DAMAGE = {
    "zone beyond the weights": {"placements": put((0, 4), 99)},
    "negative zone": {"placements": put((0, 4), -1)},
    "negative position": {"placements": put((0, 0), -7)},
    "negative source": {"placements": put((0, 3), -(10**6))},
    "placements cut short": {"placements": lambda a: a[:, :3].copy()},
    "floating placements": {"placements": lambda a: a.astype(float)},
    "weights of another kind": {"weights": lambda a: a.astype(np.float32)},
    "weights past 256": {"weights": put((0, 0, 0), 60000)},
    "flat weights": {"weights": lambda a: a.ravel()},
    "cuts of another width": {"cuts": lambda a: np.zeros((1, 3), np.uint16)},
    "no sample": {"sample_shape": lambda _: [0, 0]},
    "another format": {"format": lambda _: 99},
    "a size that is none": {"shape": lambda _: [0, -4]},
    "three sides": {"shape": lambda _: [1, 2, 3]},
}
LOAD = """
import sys, numpy as np, weftex
try:
    result = weftex.Synthesis.load(sys.argv[1])
    result.render(np.zeros((30, 34), np.uint8)); result.source
except weftex.WeftexError as error:
    print("refused:", error)
"""


@pytest.mark.parametrize("what", DAMAGE)
def test_damaged_files_are_refused(tmp_path, what):
    """In a process of its own, for a kernel that trusts a bad file brings the whole one down."""
    path = tmp_path / "result.npz"
    make().save(path)
    damage(path, **DAMAGE[what])
    done = subprocess.run(
        [sys.executable, "-c", LOAD, str(path)],
        check=False,
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert done.returncode == 0, done.stderr[-300:] or f"died of signal {-done.returncode}"
    assert done.stdout.startswith("refused:")


@pytest.mark.parametrize("size", [0, 1, 50, -1])
def test_truncated_files_are_refused(tmp_path, size):
    path = tmp_path / "result.npz"
    make().save(path)
    path.write_bytes(path.read_bytes()[:size])
    with pytest.raises(FileError, match=r"result\.npz is not a saved weftex result"):
        weftex.Synthesis.load(path)


def test_files_of_another_kind_are_refused(tmp_path):
    with pytest.raises(FileError, match="does not exist"):
        weftex.Synthesis.load(tmp_path / "nothing.npz")
    text = tmp_path / "text.npz"
    text.write_text("hello")
    with pytest.raises(FileError, match="is not a saved weftex result"):
        weftex.Synthesis.load(text)
    other = tmp_path / "other.npz"
    np.savez(other, a=np.zeros(3))
    with pytest.raises(FileError, match="is not a saved weftex result"):
        weftex.Synthesis.load(other)
    with pytest.raises(FileError):
        weftex.Synthesis.load(tmp_path)
    np.savez(other, about=np.array("[1]"), placements=0, weights=0, cuts=0)
    with pytest.raises(FileError, match="is not a saved weftex result"):
        weftex.Synthesis.load(other)
