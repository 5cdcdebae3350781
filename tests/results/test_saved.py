"""Results in files: saved, loaded, damaged."""

import json

import numpy as np
import pytest

import weftex
from families import refused
from laid import filled, make
from processes import run
from weftex.errors import FileError


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
        refused("without its sample", ask)


def test_save_writes_what_the_name_says(tmp_path):
    made = weftex.synthesize("sample:grass", 40, seed=1)
    made.save(tmp_path / "a.png")
    assert np.array_equal(weftex.read_image(tmp_path / "a.png").pixels, made.image)
    assert np.array_equal(np.asarray(made.to_pil()), made.image)
    refused("known: .*'?.npz", made.save, tmp_path / "a.pickle", error=weftex.FileError)
    deep = weftex.synthesize(np.zeros((40, 40, 3), np.uint16), 40, seed=1)
    refused("Pillow has no uint16", deep.to_pil)


def test_results_by_other_numbers_are_saved_and_of_other_samples_refused(tmp_path):
    how = {"method": "graphcut", "tone_reach": np.int64(8), "candidates": np.int32(3), "seed": 1}
    made = weftex.synthesize("sample:grass", 40, **how)
    made.save(path := tmp_path / "made.npz")
    assert weftex.Synthesis.load(path, "sample:grass").provenance == made.provenance
    for size in ((8, 8), (192, 191), (384, 384)):
        other = np.zeros((*size, 3), np.uint8)
        refused("the sample is .*; this result's was 192x192", weftex.Synthesis.load, path, other)


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
    "a side of half a pixel": {"shape": lambda _: [30.5, 34]},
    "sides of truth": {"shape": lambda _: [True, True]},
    "a negative sample": {"sample_shape": lambda _: [-30, -34]},
    "three sides of the sample": {"sample_shape": lambda _: [30, 34, 3]},
    "a sample that is a text": {"sample_shape": lambda _: "30x34"},
    "a huge sample": {"sample_shape": lambda _: [2**20, 2**20]},
    "a huge output": {"shape": lambda _: [2**20, 2**20]},
    "places that are none": {"origin": lambda _: [0.5, None]},
    "known from nowhere": {"known_from": lambda _: ["a", "b"]},
    "known from outside": {"known_from": lambda _: [5, 5]},
    "wrap of numbers": {"wrap": lambda _: [0, 1]},
    "no provenance": {"provenance": lambda _: [1]},
    "arrays of the other byte order": {"placements": lambda a: a.astype(">i4")},
    "objects": {"weights": lambda a: a.astype("datetime64[D]")},
    "more than its sizes need": {"cuts": lambda a: np.zeros((2**16, 2**10), np.uint16)},
}
LOAD = """
import sys, numpy as np, weftex
for path in sys.argv[1:]:
    print(path, flush=True)
    try:
        result = weftex.Synthesis.load(path)
        result.render(np.zeros((30, 34), np.uint8)); result.source
    except weftex.WeftexError:
        print("refused", flush=True)
"""


def test_damaged_files_are_refused(tmp_path):
    """In a process of its own, for a kernel that trusts a bad file brings the whole one down."""
    paths = [str(tmp_path / f"{what}.npz") for what in DAMAGE]
    for path, changes in zip(paths, DAMAGE.values(), strict=True):
        make().save(path)
        damage(path, **changes)
    done = run(LOAD, *paths)
    assert done.stdout.splitlines() == [line for path in paths for line in (path, "refused")]


def test_the_order_of_bytes_in_arrays_does_not_matter(tmp_path):
    result = make()
    path = tmp_path / "result.npz"
    result.save(path)
    with np.load(path) as file:
        arrays = dict(file)
    for name in ("placements", "weights", "cuts"):
        arrays[name] = np.asfortranarray(arrays[name])
    np.savez(path, **arrays)
    again = weftex.Synthesis.load(path, result.exemplar.pixels)
    assert np.array_equal(again.image, result.image)


def test_a_hole_of_another_type_is_refused(tmp_path):
    path = tmp_path / "result.npz"
    for change in (lambda a: a.astype(np.int64), lambda a: a.astype(float), np.ravel):
        filled().save(path)
        damage(path, hole=change)
        refused("its hole does not fit", weftex.Synthesis.load, path, error=FileError)


def test_a_bomb_is_refused_from_its_header(tmp_path):
    """Few kilobytes that unpack to 8 GB, of which not one is unpacked."""
    import tracemalloc
    import zipfile

    path = tmp_path / "result.npz"
    make().save(path)
    header = {"descr": "<i4", "fortran_order": False, "shape": (2**31, 1)}
    with (
        zipfile.ZipFile(path, "a", zipfile.ZIP_DEFLATED) as file,
        file.open("bomb.npy", "w", force_zip64=True) as member,
    ):
        np.lib.format.write_array_header_1_0(member, header)
        member.write(bytes(2**20))
    tracemalloc.start()
    with pytest.raises(FileError, match="its arrays are larger than its sizes need"):
        weftex.Synthesis.load(path)
    assert tracemalloc.get_traced_memory()[1] < 2**22
    tracemalloc.stop()


def test_files_of_another_kind_are_refused(tmp_path):
    refused("does not exist", weftex.Synthesis.load, tmp_path / "nothing.npz", error=FileError)
    text = tmp_path / "text.npz"
    make().save(other := tmp_path / "whole.npz")
    for damaged in (b"hello", b"", *(other.read_bytes()[:size] for size in (1, 50, -1))):
        text.write_bytes(damaged)
        with pytest.raises(FileError, match=r"text\.npz is not a saved weftex result"):
            weftex.Synthesis.load(text)
    other = tmp_path / "other.npz"
    np.savez(other, a=np.zeros(3))
    refused("is not a saved weftex result", weftex.Synthesis.load, other, error=FileError)
    refused("is not a saved weftex result", weftex.Synthesis.load, tmp_path, error=FileError)
    np.savez(other, about=np.array("[1]"), placements=0, weights=0, cuts=0)
    refused("is not a saved weftex result", weftex.Synthesis.load, other, error=FileError)
