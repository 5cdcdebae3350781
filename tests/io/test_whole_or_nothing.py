"""Files are written whole or not at all, whatever happens meanwhile."""

import os
import stat
import threading
import time
from pathlib import Path

import numpy as np
import pytest

from picture_files import FULL, RGB_PROFILE, fails, files_in, noise, smooth
from processes import run
from weftex.errors import FileError
from weftex.io import pictures as io


@pytest.mark.parametrize("suffix", FULL)
def test_no_room_to_write(tmp_path, suffix):
    """A limit on file sizes stands in for a full disk where none can be mounted."""
    path = tmp_path / f"a{suffix}"
    path.write_bytes(b"old")
    code = """
        import resource, sys
        import numpy as np
        from weftex.io import pictures as io
        pixels = np.random.default_rng(0).integers(0, 256, (200, 200, 3), "u1")
        pixels = pixels.astype("f4") if ".exr" in sys.argv[1] else pixels
        for room in (1, 30_000, 100_000):
            resource.setrlimit(resource.RLIMIT_FSIZE, (room, resource.RLIM_INFINITY))
            try:
                io.write_image(sys.argv[1], pixels)
            except io.FileError as error:
                print(error)
    """
    done = run(code, path)
    assert done.stderr == ""
    assert done.stdout == f"{path}: cannot write: File too large\n" * 3
    assert files_in(tmp_path) == [path.name]
    assert path.read_bytes() == b"old"


@pytest.mark.parametrize("suffix", FULL)
def test_the_room_made_sure_of_is_enough(tmp_path, suffix):
    """Noise is the worst case of every encoder."""
    dtype = {".png": "uint16", ".tif": "uint16", ".exr": "float32"}
    for size in ((1, 1), (1, 3000), (3000, 1), (300, 300)):
        kind = dtype.get(suffix, "uint8")
        pixels = noise((*size, 3)) if kind == "uint8" else (
            np.frombuffer(os.urandom(size[0] * size[1] * 12), "u4").astype("u2").reshape(*size, 3)
            if kind == "uint16" else noise((*size, 3), "float32"))  # fmt: skip
        io.write_image(tmp_path / f"a{suffix}", pixels, icc=RGB_PROFILE)
        used = os.path.getsize(tmp_path / f"a{suffix}")
        assert used < pixels.nbytes * 5 // 4 + len(RGB_PROFILE) + 2**16


def test_atomic_replaces_and_removes(tmp_path):
    path = tmp_path / "a.npz"
    with io.atomic(path) as temporary:
        assert os.path.dirname(temporary) == str(tmp_path)
        assert temporary.endswith(".npz")
        assert not path.exists()
        np.savez(temporary, a=np.arange(3))
    assert files_in(tmp_path) == ["a.npz"]
    old = path.read_bytes()
    for error in (ValueError, KeyboardInterrupt, SystemExit, GeneratorExit, MemoryError):
        with pytest.raises(error), io.atomic(path) as temporary:
            Path(temporary).write_bytes(b"half")
            raise error
        assert files_in(tmp_path) == ["a.npz"]
        assert path.read_bytes() == old
    with pytest.raises(FileError, match="a.npz: cannot write: No space"), io.atomic(path):
        raise OSError(28, "No space left on device")
    mine = FileError("mine")
    with pytest.raises(FileError) as info, io.atomic(path):
        raise mine
    assert info.value is mine
    with pytest.raises(FileError, match="No such file"), io.atomic(tmp_path / "no" / "a.npz"):
        pass


def test_two_writers_at_once(tmp_path):
    path = tmp_path / "a.png"
    pictures = [np.full((200, 200, 3), k, "uint8") for k in range(4)]
    threads = [
        threading.Thread(target=lambda p=p: [io.write_image(path, p) for _ in range(8)])
        for p in pictures
    ]
    for thread in threads:
        thread.start()
    while any(thread.is_alive() for thread in threads):
        if path.exists():
            assert np.ptp(io.read_image(path).pixels) == 0
    for thread in threads:
        thread.join()
    assert files_in(tmp_path) == ["a.png"]


def test_permissions(tmp_path):
    path = tmp_path / "a.png"
    for mask, mode in ((0o022, 0o644), (0o077, 0o600), (0o002, 0o664)):
        before = os.umask(mask)
        try:
            io.write_image(path, noise((4, 4)))
        finally:
            os.umask(before)
        assert stat.S_IMODE(os.stat(path).st_mode) == mode
        path.unlink()
    path.write_bytes(b"old")
    os.chmod(path, 0o640)
    io.write_image(path, noise((4, 4)))
    assert stat.S_IMODE(os.stat(path).st_mode) == 0o640


def test_symbolic_links_are_written_through(tmp_path):
    (tmp_path / "real").mkdir()
    link = tmp_path / "link.png"
    link.symlink_to(tmp_path / "real" / "a.png")
    for value in (1, 2):  # the first finds the link dangling
        io.write_image(link, np.full((3, 3), value, "uint8"))
        assert link.is_symlink()
        assert io.read_image(tmp_path / "real" / "a.png").pixels[0, 0] == value
    assert files_in(tmp_path) == ["link.png", "real"]
    assert files_in(tmp_path / "real") == ["a.png"]
    (tmp_path / "lost.png").symlink_to(tmp_path / "gone" / "a.png")
    fails(tmp_path / "lost.png", "does not exist", io.check_output)
    (tmp_path / "loop.png").symlink_to(tmp_path / "loop.png")
    fails(tmp_path / "loop.png", "cannot be overwritten", io.check_output)


def test_the_same_pixels_give_the_same_bytes(tmp_path):
    pixels = smooth(30, 40)
    for suffix in FULL:
        path = tmp_path / f"a{suffix}"
        io.write_image(path, pixels.astype("f4") if suffix == ".exr" else pixels, icc=RGB_PROFILE)
    first = {suffix: (tmp_path / f"a{suffix}").read_bytes() for suffix in FULL}
    time.sleep(1.1)  # dates are written in seconds
    (tmp_path / "other").mkdir()
    for suffix in FULL:
        path = tmp_path / "other" / f"b{suffix}"
        io.write_image(path, pixels.astype("f4") if suffix == ".exr" else pixels, icc=RGB_PROFILE)
        assert path.read_bytes() == first[suffix], suffix
