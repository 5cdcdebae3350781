"""The command: addresses, tokens, what is left when it ends, and what a restart finds."""

import os
import runpy
import signal
import stat
import sys
import time
from contextlib import suppress
from pathlib import Path
from urllib.parse import unquote, urlsplit

import numpy as np
import pytest
from pages import Page, Process

from families import refused
from weftex.cli import main
from weftex.io.pictures import write_image
from weftex.studio import server
from weftex.studio.limits import Limits, LruCache
from weftex.studio.refusals import Refusal
from weftex.studio.sessions import DAY, Store, key_of
from weftex.studio.studio import Studio


@pytest.mark.skipif(sys.platform == "win32", reason="signals are other there")
def test_killed_and_started_again(tmp_path, rng):
    """With a page open: steps are there, what ran is gone, the old token is worthless."""
    data, photo = tmp_path / "data", tmp_path / "photo.png"
    write_image(photo, rng.integers(0, 255, (60, 70, 3)).astype(np.uint8))
    first = Process(data, str(photo), "--port", "0")
    page = Page(first.client, first.token)
    opened = page.start["opened"]
    assert opened["maps"].keys() == {"color"}
    recipe = {"materials": [opened], "size": [90, 80], "seed": 5, "method": "quilting"}
    result = page.made(recipe)
    step = {"id": "0" * 12, "title": "wall", "recipe": result["recipe"], "result": result["id"]}
    kept = page.post("steps", step)
    picture = page.get(f"results/{result['id']}/picture")
    page.post("jobs", {"recipe": {**recipe, "method": "efros-leung", "size": [900, 900]}})
    assert stat.S_IMODE(data.stat().st_mode) == 0o700
    first.end(signal.SIGKILL)

    second = Process(data, "--port", str(first.client.port))
    assert second.token != first.token
    assert page.ask("GET", "jobs").status_code == 401
    again = Page(second.client, second.token, session=page.start["session"])
    assert again.start["resumed"] is True
    assert again.start["steps"] == [kept]
    assert again.get("jobs") == []
    assert again.ask("GET", f"results/{result['id']}/picture").status_code == 410
    assert again.made(kept["recipe"])["id"] == result["id"]
    assert again.get(f"results/{result['id']}/picture") == picture
    stranger = Page(second.client, second.token, session="x" * 43)
    assert stranger.start["steps"] == []
    (work,) = stranger.get("works")["works"]
    assert (work["title"], work["steps"]) == ("wall", 1)
    assert stranger.post(f"works/{work['id']}/open")["steps"] == [kept]
    assert stranger.made(kept["recipe"])["id"] == result["id"]  # by its own copy of the photo
    assert stranger.ask("DELETE", f"works/{work['id']}").status_code == 409  # open in a tab
    again.post("jobs", {"recipe": {**recipe, "method": "efros-leung", "size": [900, 900]}})
    assert second.end(signal.SIGTERM) in (0, -signal.SIGTERM, 143)
    left = [one.name for one in data.iterdir() if one.name.startswith("out-")]
    assert len(left) <= 1  # that of the killed one
    used = {key_of(one.start["session"]) for one in (page, stranger)}
    assert {one.name for one in data.iterdir()} - set(left) == used


def test_its_socket_is_of_this_machine_alone():
    with server.listen(None) as one, server.listen(None) as two:
        assert one.getsockname()[0] == two.getsockname()[0] == "127.0.0.1"
        assert one.getsockname()[1] != two.getsockname()[1]
        refused("cannot listen at 127.0.0.1:", server.listen, one.getsockname()[1], error=OSError)


def test_only_the_address_is_said(monkeypatch, tmp_path, capsys):
    served = []
    monkeypatch.setattr("uvicorn.Server.run", lambda self, sockets: served.extend(sockets))
    words = ["studio", "--no-browser", "--port", "0", "--data", str(tmp_path)]
    assert main(words) == 0
    assert capsys.readouterr().err.count("\n") == 1  # the address alone
    for one in served:
        one.close()
    assert server.hosts_of(8427) == {"127.0.0.1:8427", "localhost:8427"}


@pytest.mark.parametrize(
    "words", [["nowhere.png"], ["--port", "99999"], ["--memory", "1"],
              ["--prot", "8"], ["a", "b"], ["--data", ""]],
)  # fmt: skip
def test_wrong_words_are_one_line(words, tmp_path, capsys):
    assert main(["studio", "--data", str(tmp_path), *words]) == 2
    said = capsys.readouterr().err
    assert said.startswith("weftex: error: ") and said.count("\n") == 1


@pytest.mark.skipif(sys.platform == "win32", reason="permissions are other there")
def test_permissions_of_a_data_folder(tmp_path, capsys):
    """A new one is the owner's alone; an old one is as it was, and refused if others can write."""
    new, old, shared = (tmp_path / name for name in ("new", "old", "shared"))
    old.mkdir(mode=0o755)
    shared.mkdir()
    for mode in (0o777, 0o770, 0o1777):
        shared.chmod(mode)
        assert main(["studio", "--no-browser", "--port", "0", "--data", str(shared)]) == 2
        line = f"other users can write to this folder (mode {mode & 0o777:o}); name another"
        assert line in capsys.readouterr().err
        assert (stat.S_IMODE(shared.stat().st_mode), list(shared.iterdir())) == (mode, [])
    for folder, mode in ((new, 0o700), (old, 0o755)):
        opened = Studio(folder, Limits())
        session, _ = opened.open_session(None)
        session.add_steps([{"id": "a"}])
        assert stat.S_IMODE(folder.stat().st_mode) == mode
        for inner in folder.iterdir():
            assert stat.S_IMODE(inner.stat().st_mode) == 0o700
        opened.close()


@pytest.mark.skipif(sys.platform == "win32", reason="permissions are other there")
def test_a_folder_that_others_can_replace_is_refused(tmp_path, capsys):
    """New folders above it are the owner's alone, whatever the umask."""
    tmp_path.chmod(0o777)
    assert main(["studio", "--no-browser", "--port", "0", "--data", str(tmp_path / "a")]) == 2
    assert "other users can replace this folder, since they can" in capsys.readouterr().err
    tmp_path.chmod(0o1777)
    before = os.umask(0)
    try:
        Studio(tmp_path / "b" / "c" / "d", Limits()).close()
    finally:
        os.umask(before)
    modes = [stat.S_IMODE((tmp_path / name).stat().st_mode) for name in ("b", "b/c", "b/c/d")]
    assert modes == [0o700] * 3


@pytest.mark.skipif(sys.platform == "win32", reason="the browser here is a shell script")
def test_the_token_is_in_no_command_line(tmp_path, monkeypatch):
    """A browser reads it in a file that its owner alone can read, and that is removed then."""
    said, browser = tmp_path / "said", tmp_path / "browser"
    browser.write_text(f'#!/bin/sh\necho "$1" > {said}.new && mv {said}.new {said}\nsleep 2\n')
    browser.chmod(0o755)
    monkeypatch.setenv("BROWSER", f"{browser} %s &")
    studio = Process(tmp_path / "data", "--port", "0", browser=True)
    end = time.monotonic() + 60
    while not said.exists() and time.monotonic() < end:
        time.sleep(0.02)
    address = said.read_text().strip()
    page = Path(unquote(urlsplit(address).path))
    assert urlsplit(address).scheme == "file" and studio.token not in address
    assert stat.S_IMODE(page.stat().st_mode) == 0o600
    assert stat.S_IMODE(page.parent.stat().st_mode) == 0o700
    assert f"url=http://127.0.0.1:{studio.client.port}/#token={studio.token}" in page.read_text()
    for about in Path("/proc").glob("[0-9]*/cmdline"):  # on Linux
        with suppress(OSError):
            assert studio.token.encode() not in about.read_bytes()
    Page(studio.client, studio.token)
    while page.exists() and time.monotonic() < end:
        time.sleep(0.02)
    assert not page.exists()
    studio.end(signal.SIGTERM)


def test_without_the_extra_it_says_what_to_install(monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "starlette", None)
    assert main(["studio"]) == 2
    assert "pip install 'starlette>=0.40' 'uvicorn>=0.30'" in capsys.readouterr().err


def test_what_is_left_over_is_swept(tmp_path):
    limits, names = Limits(), [key_of(str(k)) for k in range(4)]
    for k, name in enumerate(names):
        (tmp_path / name).mkdir()
        (tmp_path / name / ".new-1").write_bytes(b"x" * 100)
        (tmp_path / name / ("steps.json" if k % 2 else "a.json")).write_text("[]")
        for path in (tmp_path / name / ".new-1", tmp_path / name):
            old = time.time() - (DAY * 3 if k < 2 else 0)
            os.utime(path, (old, old))
    (tmp_path / "others").mkdir()
    found = Store(tmp_path, limits)
    own = found.downloads.folder.name
    assert {one.name for one in tmp_path.iterdir()} == {*names[1:], "others", own}
    left = {one.parent.name for one in tmp_path.rglob(".new-*")}
    assert left == set(names[2:])  # those of yesterday are not of a server that runs
    assert found.bytes == 200


def test_the_oldest_work_that_nobody_uses_gives_way(tmp_path):
    names = [key_of(str(k)) for k in range(3)]
    for k, name in enumerate(names):
        (tmp_path / name).mkdir()
        (tmp_path / name / "a.png").write_bytes(b"x" * 100)
        os.utime(tmp_path / name, (time.time() - (2 - k) * DAY / 2,) * 2)
    found = Store(tmp_path, Limits(stored_bytes=300))
    found.reserve(150)
    assert ({one.name for one in found.sessions()}, found.bytes) == ({names[2]}, 250)
    refused("remove earlier work", found.reserve, 51, error=Refusal)


def test_pages_that_are_open_are_bounded(tmp_path):
    studio = Studio(tmp_path, Limits(sessions=2))
    one, two = (studio.open_session(None)[0] for _ in range(2))
    refused("2 pages are open; close one of them", studio.open_session, None, error=Refusal)
    one.seen -= 100  # a tab that was closed long ago
    one.remember("made", 4, "result")
    three, resumed = studio.open_session(None)
    assert (one.recall("result"), resumed) == (None, False)
    refused("page", studio.session, one.id, error=Refusal)
    assert studio.open_session(two.id) == (two, True)
    assert studio.session(three.id) is three
    studio.close()


def test_what_is_remembered_is_bounded():
    memory = LruCache(100)
    for k in range(50):
        memory.put(("tab" if k < 49 else "other", k), object(), 30)
        assert memory.bytes <= 100
    assert [k for k in range(50) if memory.get(("tab", k)) is not None] == [47, 48]
    memory.forget("tab")
    assert (memory.get(("tab", 48)), memory.bytes) == (None, 30)


@pytest.mark.pages
def test_its_benchmark_runs(tmp_path):
    script = Path(__file__).parents[2] / "benchmarks" / "speed" / "studio.py"
    [(what, figure)] = runpy.run_path(str(script))["start"](tmp_path, 1)
    assert "to the sample's picture" in what and figure.endswith(")")
