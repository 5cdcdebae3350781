"""Temporary files of a killed process are removed later, those of a living one never."""

import os
import signal
import subprocess
import sys
import textwrap
from pathlib import Path

import numpy as np
import pytest

from picture_files import FULL, files_in, noise
from processes import ENVIRONMENT, WITH_HELPERS, run
from weftex.errors import FileError
from weftex.io import pictures as io
from weftex.io import temporary

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="nothing is locked there")
HOLD = """
    import sys, time
    from weftex.io import temporary
    temporary.claim(sys.argv[1], ".png")
    temporary.claim(sys.argv[1], as_folder=True)
    print(flush=True)
    time.sleep(60)
"""


@pytest.fixture
def holder(tmp_path):
    """A process that has a temporary file and a temporary folder."""
    temporary._sweep.cache_clear()
    command = [sys.executable, "-c", textwrap.dedent(HOLD), str(tmp_path)]
    with subprocess.Popen(command, env=ENVIRONMENT, stdout=subprocess.PIPE) as process:
        process.stdout.readline()
        yield process
        process.kill()


def test_what_a_dead_process_left_is_removed(tmp_path, holder):
    own = [
        ".weftex-12-notes.png",  # other names, other machines, and links
        f".weftex-{holder.pid}-00000000-0badf00d.png",
    ]
    for name in own:
        (tmp_path / name).write_text("mine")
    link = f".weftex-{holder.pid}-{temporary._machine()}-0badf00d.png"
    (tmp_path / link).symlink_to(tmp_path / own[0])
    assert len(files_in(tmp_path)) == 5
    io.write_image(tmp_path / "a.png", noise((4, 4)))
    assert len(files_in(tmp_path)) == 6  # it lives
    holder.send_signal(signal.SIGKILL)
    holder.wait()
    temporary._sweep.cache_clear()
    io.write_image(tmp_path / "a.png", noise((4, 4)))
    assert files_in(tmp_path) == sorted([*own, link, "a.png"])


def test_a_picture_is_whole_whenever_its_writer_is_killed(tmp_path):
    """The old one or the new one; the next that is written leaves nothing else behind."""
    code = """
    import os, sys
    from pathlib import Path
    import numpy as np
    from processes import killed_at
    from weftex.io import pictures as io, temporary
    folder, number, died = Path(sys.argv[1]), 0, True
    old, new = np.zeros((9, 9), np.uint8), np.ones((9, 9), np.uint8)
    while died:
        number += 1
        temporary._sweep.cache_clear()
        io.write_image(folder / "a.png", old)
        assert os.listdir(folder) == ["a.png"], number
        died = killed_at(number, lambda: io.write_image(folder / "a.png", new), folder)
        found = io.read_image(folder / "a.png").pixels
        assert (found == new).all() or died and (found == old).all(), number
    print(number)
    """
    assert int(run(code, tmp_path, env=WITH_HELPERS).stdout) > 3


@pytest.mark.parametrize("suffix", [*FULL, ".npz"])
def test_a_file_stays_locked_while_it_is_written(tmp_path, suffix):
    """Also where one writer is inside another: no encoder may put another file in its place."""
    pixels = noise((9, 9, 3), "float32" if suffix == ".exr" else "uint8")
    with io.atomic(tmp_path / f"a{suffix}") as path:
        if suffix == ".npz":
            with io.atomic(path) as inner:
                np.savez(inner, pixels)
        else:
            io.write_image(path, pixels)
        temporary._sweep.cache_clear()
        temporary._sweep(str(tmp_path))
        assert os.path.getsize(path) and files_in(tmp_path) == [Path(path).name]
    assert files_in(tmp_path) == [f"a{suffix}"]


def test_errors_name_the_file_that_was_asked_for(tmp_path, monkeypatch):
    monkeypatch.setattr(io, "encode", lambda *_: "no room\nand more")
    with pytest.raises(FileError) as info, io.atomic(tmp_path / "a.tif") as path:
        io.write_image(path, noise((4, 4)))
    assert str(info.value) == f"{tmp_path / 'a.tif'}: cannot write: no room"
    assert not files_in(tmp_path)


def test_a_file_is_on_the_disk_before_it_appears(tmp_path, monkeypatch):
    calls = []
    for name in ("fsync", "replace"):
        act = getattr(os, name)
        monkeypatch.setattr(os, name, lambda *a, act=act, name=name: (calls.append(name), act(*a)))
    io.write_image(tmp_path / "a.png", noise((4, 4)))
    assert calls == ["fsync", "replace"]
