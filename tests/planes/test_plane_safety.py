"""Planes on disk whose files are foreign, damaged, or written by a run that ought to have ended."""

import json
import os
import shutil
import signal
import sys
import threading
from contextlib import contextmanager, suppress
from pathlib import Path

import numpy as np
import pytest

import weftex
from commands import listing
from families import noise, refused
from processes import WITH_HELPERS, run
from weftex import planes
from weftex.errors import CancelledError, FileError
from weftex.io.pictures import write_image
from weftex.planes import check, open_plane, stream
from weftex.planes.beginning import at_work
from weftex.planes.definition import define
from weftex.planes.plane_file import PlaneFile
from weftex.planes.record import Record
from weftex.planes.tiff import TiffStore
from weftex.planes.writing import block_maker, write_plane

SIZE = (200, 333)
TILE = weftex.BestTile(lattice=(20, 0, 0, 20))
HOW = {"method": TILE, "seed": 4, "block": 64, "threads": 1}
SAMPLE = noise((60, 64, 3))


@pytest.fixture(autouse=True)
def without_a_disk(monkeypatch):
    """Nobody pulls the plug here."""
    monkeypatch.setattr(os, "fsync", lambda number: None)


@pytest.fixture
def target(tmp_path):
    return tmp_path / "p.tif"


def pixels_of(folder):
    """The files of planes, without what is known of them."""
    return {p: data for p, data in listing(folder).items() if data and ".run" not in str(p)}


def plane_of(target, seed, size=SIZE, **part):
    return PlaneFile(define(SAMPLE, size, TILE, {}, seed=seed, block=64), str(target), **part)


def is_whole(target):
    """Whether everything is there, and as it was written."""
    with suppress(FileError):
        return bool(check(target, read=True))


def repair(target):
    return planes.repair(target, threads=1).made


def test_a_restart_waits_for_a_block_that_is_being_written(tmp_path, target, monkeypatch):
    """Else it would be written into the file of the new run, after the check."""
    stream(SAMPLE, tmp_path / "whole.tif", SIZE, **HOW)
    old = plane_of(target, 9)
    with at_work(old) as record:
        block_maker(old)((record.run, (0, 0, 0)))
    put, writing, go = TiffStore.put, threading.Event(), threading.Event()

    def slow(self, place, pixels):
        writing.set()
        assert go.wait(20)
        put(self, place, pixels)

    monkeypatch.setattr(TiffStore, "put", slow)

    def task():
        with pytest.raises(FileError, match="another command restarted"):  # it is not noted as done
            block_maker(old)((record.run, (0, 1, 1)))

    late = threading.Thread(target=task)
    late.start()
    assert writing.wait(20)
    monkeypatch.undo()
    again = threading.Thread(
        target=stream, args=(SAMPLE, target, SIZE), kwargs={"restart": True, **HOW}
    )
    again.start()
    again.join(0.3)
    assert again.is_alive()
    go.set()
    late.join(20)
    again.join(20)
    assert target.read_bytes() == (tmp_path / "whole.tif").read_bytes() and is_whole(target)


def test_a_worker_goes_on_when_its_plane_was_begun_again(tmp_path, target):
    """It writes to the journal that is there, not to one that was removed."""
    plane = plane_of(target, 4)
    make = block_maker(plane)

    def worker(record, level, steps):
        for place in level:
            make((record.run, place))
            yield place

    for _ in range(2):
        write_plane(plane, runner=worker)
        assert is_whole(target)
        write_plane(plane, runner=worker, restart=True)
        assert is_whole(target)
        for path in tmp_path.iterdir():
            shutil.rmtree(path) if path.is_dir() else path.unlink()


@pytest.mark.parametrize(
    ("mine", "why"),
    [
        ("p.tif", "exists already"),
        ("p.tif/0", "is a folder"),
        ("p.tif.run/0", "contains other files"),
    ],
)
@pytest.mark.parametrize("recorded", [False, True])  # that a file of weftex is there
def test_files_and_folders_of_others_are_kept(tmp_path, target, mine, why, recorded):
    if recorded and mine == "p.tif/0":
        stream(SAMPLE, target, SIZE, **HOW)
        target.unlink()
    (tmp_path / mine).parent.mkdir(exist_ok=True)
    (tmp_path / mine).write_bytes(b"mine")
    before = listing(tmp_path)
    for restart in (False, True):
        refused(why, stream, SAMPLE, target, SIZE, restart=restart, **HOW, error=FileError)
    assert listing(tmp_path) == before


@pytest.mark.skipif(sys.platform == "win32", reason="links need a privilege there")
def test_nothing_is_written_through_a_link(tmp_path):
    """Whether a record says that the plane is weftex's, and whether the link leads anywhere."""
    target, other = tmp_path / "p.tif", tmp_path / "other"
    for there in (False, True):
        target.symlink_to(other)
        if there:
            other.write_bytes(b"precious")
        for restart in (False, True):
            with pytest.raises(FileError, match="p.tif is a link; remove it"):
                stream(SAMPLE, target, SIZE, restart=restart, **HOW)
        assert (other.read_bytes() if there else other.exists()) == (b"precious" if there else 0)
        target.unlink()
    stream(SAMPLE, target, SIZE, **HOW)
    target.unlink()
    target.symlink_to(other)
    refused("is a link", stream, SAMPLE, target, SIZE, restart=True, **HOW, error=FileError)
    refused("is a link", repair, target, error=FileError)
    assert other.read_bytes() == b"precious"


@pytest.mark.skipif(sys.platform == "win32", reason="forks")
@pytest.mark.parametrize("restart", [False, True])
def test_killed_at_any_call_of_the_start(tmp_path, restart):
    """The same command makes the same bytes, and leaves no temporary file."""
    code = """
    import os, shutil, sys
    from pathlib import Path
    import numpy as np
    import weftex
    from commands import listing
    from processes import killed_at
    os.fsync = lambda number: None  # a killed process needs none
    folder, restart = Path(sys.argv[1]), sys.argv[2] == "True"
    sample = np.arange(60 * 64 * 3).astype(np.uint8).reshape(60, 64, 3)
    tile = weftex.BestTile(lattice=(20, 0, 0, 20))

    def make(target, seed=4, **how):
        weftex.planes.stream(sample, target, 4, method=tile, seed=seed, block=64, threads=1, **how)

    def pixels(name):
        return {p.relative_to(folder / name): d for p, d in listing(folder / name).items() if d}

    def kept(name):
        return {p: d for p, d in pixels(name).items() if "p.tif.run" not in p.parts}

    for name in ("whole", "p"):
        (folder / name).mkdir()
    make(folder / "whole" / "p.tif")
    number = 0
    while True:
        number += 1
        shutil.rmtree(folder / "p")
        (folder / "p").mkdir()
        target = folder / "p" / "p.tif"
        if restart:
            make(target, seed=5)
        work = lambda: make(target, restart=restart)
        died = killed_at(number, work, folder)
        work()
        assert kept("p") == kept("whole"), number
        assert {*pixels("p")} == {*pixels("whole")}, (number, {*pixels("p")})
        if not died:
            break
    print(number)
    """
    done = run(code, tmp_path, restart, env=WITH_HELPERS, timeout=120)
    assert int(done.stdout) > 30


def test_a_recipe_of_another_run_is_refused(tmp_path, target):
    stream(SAMPLE, target, SIZE, **HOW)
    recipe = tmp_path / "p.tif.run" / "recipe.npz"
    data = recipe.read_bytes()
    stream(SAMPLE, target, SIZE, restart=True, **HOW)
    recipe.write_bytes(data)
    refused("it belongs to another run", open_plane, target, error=FileError)


def test_what_is_missing_or_damaged_is_repaired(tmp_path, target):
    stream(SAMPLE, target, (70, 60), **HOW)
    whole = pixels_of(tmp_path)
    assert repair(target) == 0
    for path, data in whole.items():
        middle = 2**16  # the first pixel
        flipped = data[:middle] + bytes([data[middle] ^ 8]) + data[middle + 1 :]
        for bad in (None, b"", data[:middle], flipped):
            path.unlink()
            if bad is not None:
                path.write_bytes(bad)
            assert not is_whole(target)
            assert repair(target) > 0
            assert is_whole(target) and pixels_of(tmp_path) == whole


def test_smaller_versions_are_made_of_whole_blocks_only(tmp_path, target):
    """Else damage would be in them, with the right check sum."""
    stream(SAMPLE, target, 600, **HOW)
    whole = pixels_of(tmp_path)

    def stop(done, *_):
        return done < 100  # of level 0

    with pytest.raises(CancelledError):
        stream(SAMPLE, target, 600, restart=True, progress=stop, **HOW)
    store = open_plane(target).stores["color"]
    store.write((0, 2, 3), 255 - store.read(0, store.layout.window((0, 2, 3))))
    with pytest.raises(FileError, match="level 0, row 2, column 3 is damaged.*check --repair"):
        stream(SAMPLE, target, 600, **HOW)
    repair(target)
    assert is_whole(target) and pixels_of(tmp_path) == whole
    store.write((0, 2, 3), 255 - store.read(0, store.layout.window((0, 2, 3))))
    assert repair(target) == store.levels  # the block and all that is made of it


@pytest.mark.parametrize("begun", [False, True])
def test_files_that_are_not_of_the_plane_are_never_removed(tmp_path, target, begun):
    stream(SAMPLE, target, 70, **HOW)
    path = tmp_path / f"{target.name}.run" / "run.json"
    said = json.loads(path.read_text())
    mine = tmp_path / "mine"
    mine.mkdir()
    own = f"{target.stem}_mine.tif"
    near = [tmp_path / name for name in ("notes.txt", own, "mine/a.tif")]
    for file in near:
        file.write_bytes(b"mine")
    for name in ("notes.txt", own, "mine", "mine/a.tif"):
        path.write_text(json.dumps(said | {"begun": begun, "files": [*said["files"], name]}))
        try:
            stream(SAMPLE, target, 70, restart=begun, **HOW)
        except FileError as error:
            assert f"lists {name}, which no plane" in str(error) or "is damaged" in str(error)
        else:
            assert name == own  # left where it is
        assert all(file.read_bytes() == b"mine" for file in near)


@contextmanager
def _limited():
    """Raise after 20 s, and where 1 GiB more of memory is asked for than there was."""
    resource = pytest.importorskip("resource")

    def late(*_):
        raise TimeoutError

    before = resource.getrlimit(resource.RLIMIT_AS)
    used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    handler = signal.signal(signal.SIGALRM, late)
    resource.setrlimit(resource.RLIMIT_AS, (used + 2**30, before[1]))
    signal.alarm(20)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, handler)
        resource.setrlimit(resource.RLIMIT_AS, before)


def _read_all(target):
    for store in open_plane(target).stores.values():
        with suppress(FileError):
            store.read(0, (0, 0, 70, 70))
    check(target, read=True)


@pytest.mark.skipif(sys.platform != "linux", reason="memory is counted there")
def test_pipes_devices_and_files_without_an_end_are_refused(tmp_path, target):
    stream(SAMPLE, target, 70, **HOW)
    folder = tmp_path / f"{target.name}.run"
    files = [*pixels_of(tmp_path), *(folder / n for n in ("run.json", "recipe.npz", "done.txt"))]
    for path in files:
        data = path.read_bytes()
        makers = {
            "pipe": lambda path=path: os.mkfifo(path),
            "device": lambda path=path: path.symlink_to("/dev/zero"),
            "long": lambda path=path: (path.touch(), os.truncate(path, 2**33)),
        }
        for kind, make in makers.items():
            path.unlink()
            make()
            with _limited(), pytest.raises(FileError) as caught:
                _read_all(target)
            assert "\n" not in str(caught.value), (path, kind)
        path.unlink()
        path.write_bytes(data)
    _read_all(target)


def test_a_tiff_of_too_many_tiles(target):
    refused("at most 4194304 tiles, not .* use a larger", stream, SAMPLE, target, 2**20, **HOW)


def test_a_renamed_sample_is_the_same(tmp_path):
    for name in ("a", "b"):
        write_image(tmp_path / f"{name}.png", SAMPLE)
    stream(tmp_path / "a.png", tmp_path / "p.tif", SIZE, **HOW)
    assert stream(tmp_path / "b.png", tmp_path / "p.tif", SIZE, **HOW).made == 0
    changed = np.array(SAMPLE)
    changed[0, 0] ^= 1
    write_image(tmp_path / "b.png", changed)
    refused("its sample is different", stream, tmp_path / "b.png", tmp_path / "p.tif", SIZE, **HOW)


def test_another_version_is_refused(target, monkeypatch):
    stream(SAMPLE, target, SIZE, **HOW)
    monkeypatch.setattr(weftex, "__version__", "99.0")
    refused(r"its version of weftex is .*, here '99\.0'", stream, SAMPLE, target, SIZE, **HOW)


def test_a_removed_plane_is_not_touched_by_the_run_that_made_it(tmp_path, target):
    """Nor does that run, when it fails, remove the one that was begun since."""
    old = plane_of(target, 9)
    with pytest.raises(FileError, match="restarted or removed"), at_work(old) as record:
        for path in tmp_path.iterdir():
            shutil.rmtree(path) if path.is_dir() else path.unlink()
        run(_STREAM, target)
        old.make(record, (0, 0, 0), threads=1)
    assert is_whole(target) and Record(str(target)).begun()


_STREAM = """
import sys
import numpy as np
import weftex
weftex.planes.stream(np.arange(60 * 64).astype(np.uint8).reshape(60, 64), sys.argv[1], 100,
              method=weftex.BestTile(lattice=(20, 0, 0, 20)), seed=1, block=64)
"""
