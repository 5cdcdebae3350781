"""Every route that changes state, asked many times at once, and on a full disk."""

import builtins
import errno
import io
import json
import os
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from test_jobs import LONG, QUICK, idle

from conftest import SMALL, serving
from weftex.io.png import png_bytes
from weftex.studio import app, exports, uploads  # noqa: F401
from weftex.studio.requests import ROUTES
from weftex.studio.sessions import Session
from weftex.studio.studio import Studio

TIMES = 20
CHANGING = [f"{method} {path}" for method, path, _ in ROUTES if method != "GET"]


def png(seed, side=20):
    pixels = np.random.default_rng(seed).integers(0, 255, (side, side, 3))
    return png_bytes(pixels.astype(np.uint8))


def at_once(page, requests):
    """The answers to requests (method, path, content) that leave at the same moment."""
    ready = threading.Barrier(len(requests))

    def ask(request):
        ready.wait()
        method, path, content = request
        content = content if isinstance(content, bytes) else json.dumps(content)
        return page.ask(method, path, content=content)

    with ThreadPoolExecutor(len(requests)) as pool:
        return list(pool.map(ask, requests))


def codes(answers):
    return sorted(answer.status_code for answer in answers)


def stored(client):
    """The bytes of uploads that are on the disk, and no half of one."""
    folder = client.studio.store.folder
    assert not list(folder.rglob(".new-*")) and not list(folder.rglob(".weftex-*"))
    names = [one for one in folder.glob("[0-9a-f]*/*") if one.suffix not in (".json", "")]
    return sum(one.stat().st_size for one in names)


def made(page, count=1):
    each = [{"seed": seed} for seed in range(count)]
    return [one["id"] for one in page.job(QUICK, each=each)["results"]]


def color(upload):
    return {"maps": {"color": upload["id"]}}


def same(path, wanted):
    """A case of a route that gives one answer, however often it is asked."""

    def case(client, page):
        own = {"session": page.start["session"]}
        given = wanted(page) if callable(wanted) else wanted or own
        answers = at_once(page, [("POST", path, given)] * TIMES)
        assert len({answer.content for answer in answers}) == 1 and codes(answers) == [200] * TIMES

    return case


def leave(client, page):
    page.post("jobs", {"recipe": LONG})
    assert codes(at_once(page, [("POST", "leave", {})] * TIMES)) == [200] * TIMES
    assert idle(client)


def upload(client, page):
    before = client.studio.store.bytes
    same = at_once(page, [("POST", "uploads", png(0))] * TIMES)
    assert codes(same) == [200] * TIMES
    assert client.studio.store.bytes - before == len(png(0))
    most = client.studio.limits.uploads
    answers = at_once(page, [("POST", "uploads", png(k)) for k in range(1, TIMES)])
    assert codes(answers) == [200] * (most - 1) + [413] * (TIMES - most)
    assert len(page.session.uploads) == most
    assert client.studio.store.bytes == stored(client)


def jobs(client, page):
    most = client.studio.limits.session_jobs
    answers = at_once(page, [("POST", "jobs", {"recipe": LONG})] * TIMES)
    assert codes(answers) == [200] * most + [429] * (TIMES - most)
    page.post("leave")
    assert idle(client)


def end_job(client, page):
    path = f"jobs/{page.post('jobs', {'recipe': LONG})['id']}"
    assert set(codes(at_once(page, [("DELETE", path, b"")] * TIMES))) <= {200, 404}
    assert idle(client)


def export(kind, **wanted):
    """A case of a route that writes the same files, however often it is asked."""

    def case(client, page):
        path, before = f"{kind(page)}/exports", folders(client)
        answers = at_once(page, [("POST", path, wanted)] * TIMES)
        assert codes(answers) == [200] * TIMES
        tickets = {answer.json()["ticket"] for answer in answers}
        assert len({client.get(f"/api/downloads/{one}").content for one in tickets}) == 1
        assert (len(tickets), folders(client) - before) == (TIMES, TIMES)

    return case


def result(page):
    return f"results/{made(page)[0]}"


def material(page):
    return f"materials/{page.post('materials', color(page.upload(png(0, side=64))))['id']}"


def atlas(page):
    return f"atlases/{page.found(f'{material(page)}/atlases', {'tile_size': 32})['id']}"


def steps(client, page):
    results = made(page, 16)
    answers = at_once(page, [("POST", "steps", step(one)) for one in results])
    assert codes(answers) == [200] * 16
    again = Session(client.studio.store, client.studio.memory, page.start["session"])
    for found in (page.session.steps, again.steps):  # also for a server that starts again
        assert {one["result"]["id"] for one in found} == set(results) and len(found) == 16


def step(result, **more):
    return {"id": result[:12], "label": "Made", "recipe": QUICK, "result": result, **more}


def use_as_sample(client, page):
    (result,) = made(page)
    answers = at_once(page, [("POST", f"results/{result}/sample", b"")] * TIMES)
    assert codes(answers) == [200] * TIMES
    (spec,) = {json.dumps(answer.json()) for answer in answers}
    assert page.made({**QUICK, "materials": [json.loads(spec)]})["id"] != result
    assert client.studio.store.bytes == stored(client)


def estimates(client, page):
    path = f"materials/{page.post('materials', color(page.upload(png(0))))['id']}/estimates"
    answers = at_once(page, [("POST", path, {})] * TIMES)
    assert set(codes(answers)) <= {200, 429}
    jobs = [page.wait(answer.json()) for answer in answers if answer.status_code == 200]
    (spec,) = {json.dumps(job["results"]) for job in jobs}
    assert json.loads(spec)[0]["maps"].keys() == {"color", "height", "normal_gl", "ao", "roughness"}
    assert client.studio.store.bytes == stored(client)


def left_work(client):
    """The key of a tab that uploaded, made a step and went."""
    left = client.page()
    key = left.session.key
    left.post("steps", step(made(left)[0]))
    left.upload(png(5))
    left.post("leave")
    return key


def continue_work(client, page):
    key = left_work(client)
    answers = at_once(page, [("POST", f"works/{key}/open", b"")] * TIMES)
    assert set(codes(answers)) <= {200, 404} and 200 in codes(answers)
    assert (len(page.session.steps), len(page.session.uploads)) == (1, 1)
    assert client.studio.store.bytes == stored(client)
    assert page.get("works")["works"] == []


def remove_work(client, page):
    key, own = left_work(client), page.session.key
    page.upload(png(6))
    assert page.ask("DELETE", f"works/{own}").status_code == 409
    answers = at_once(page, [("DELETE", f"works/{key}", b"")] * TIMES)
    assert set(codes(answers)) <= {200, 404}
    assert not (client.studio.store.folder / key).exists()
    assert client.studio.store.bytes == stored(client)


def folders(client):
    """How many files wait to be downloaded, or are left of an export."""
    return len(list(client.studio.downloads.folder.iterdir()))


def measured(kind, what, is_right):
    """A case of a route that queues a job, which ends the one before it."""

    def case(client, page):
        path = f"{kind(page)}/{what}"
        answers = at_once(page, [("POST", path, {})] * TIMES)
        assert 200 in codes(answers) and set(codes(answers)) <= {200, 429}
        assert is_right(page.found(path))
        assert idle(client)

    return case


def presets(client, page):
    chain = [{"label": "Made", "recipe": QUICK | {"materials": [{"maps": {"color": "photo"}}]}}]
    names = [f"preset {number}" for number in range(TIMES)]
    asked = [("POST", "presets", {"name": name, "steps": chain}) for name in names]
    assert codes(at_once(page, asked)) == [200] * TIMES
    assert sorted(page.get("presets")) == sorted(names)
    answers = at_once(page, [("POST", "presets", {"name": names[0]})] * TIMES)
    assert codes(answers) == [200] + [404] * (TIMES - 1)


WEAVE = {"materials": [{"sample": "weave"}], "method": "best-tile", "seed": 1}
CASES = {
    "POST /session": same("session", None), "POST /leave": leave, "POST /uploads": upload,
    "POST /sets": same("sets", lambda page: {"uploads": [page.upload(png(0))["id"]]}),
    "POST /materials": same("materials", lambda page: color(page.upload(png(0)))),
    "POST /materials/{id}/estimates": estimates,
    "POST /materials/{id}/look": measured(material, "look", lambda found: found["scale"] > 0),
    "POST /materials/{id}/borders": measured(material, "borders", lambda found: found["maps"]),
    "POST /results/{id}/borders": measured(result, "borders", lambda found: found["maps"]),
    "POST /materials/{id}/atlases": measured(material, "atlases", lambda found: found["tiles"]),
    "POST /results/{id}/atlases": measured(result, "atlases", lambda found: found["tiles"]),
    "POST /jobs": jobs, "POST /planes": same("planes", WEAVE),
    "POST /results/{id}/figures": measured(result, "figures", lambda found: found["score"] > 0),
    "POST /results/{id}/exports": export(result, format=".png", recipe=True),
    "POST /materials/{id}/exports": export(material, preset="unreal"),
    "POST /atlases/{id}/exports": export(atlas, name="rock"),
    "POST /results/{id}/sample": use_as_sample,
    "POST /steps": steps, "POST /presets": presets, "POST /works/{id}/open": continue_work,
    "DELETE /works/{id}": remove_work,
    "DELETE /jobs/{id}": end_job,
}  # fmt: skip


@pytest.fixture
def client(tmp_path):
    with serving(tmp_path) as found:
        yield found


@pytest.mark.parametrize("route", CHANGING)
def test_many_requests_at_once(client, page, route):
    CASES[route](client, page)


@pytest.fixture
def full_disk(monkeypatch):
    """Files can be created, and nothing can be written to them; a function begins it."""
    real = io.open

    class Full(io.BytesIO):
        def write(self, data):
            raise OSError(errno.ENOSPC, "No space left on device")

    def begin(folder):
        def opened(file, mode="r", *more, **how):
            writes = set(mode) & set("wax+") and isinstance(file, (str, Path))
            if not writes or Path(folder) not in Path(file).resolve().parents:
                return real(file, mode, *more, **how)
            real(file, mode, *more, **how).close()
            return Full()

        monkeypatch.setattr(builtins, "open", opened)
        monkeypatch.setattr(io, "open", opened)

    return begin


def test_on_a_full_disk_requests_say_so(client, page, full_disk):
    """Nothing that failed is left, and what was there before is there still."""
    page.upload(png(0))
    (result,) = made(page)
    kept = page.post("steps", step(result, label="before"))
    before = {one: one.stat().st_size for one in client.studio.store.folder.rglob("*")}
    count = client.studio.store.bytes
    full_disk(client.studio.store.folder.resolve())
    wanted = [
        ("POST", "uploads", png(1)),
        ("POST", f"results/{result}/exports", {"format": ".png"}),
        ("POST", f"results/{result}/exports", {"recipe": True, "preset": "unity-urp"}),
        ("POST", "steps", step(result, label="after")),
        ("POST", f"results/{result}/sample", b""),
    ]
    for answer in at_once(page, wanted):
        assert (answer.status_code, answer.json()["error"][:16]) == (507, "the disk is full")
        assert str(client.studio.store.folder) not in answer.text
    assert page.session.steps == [kept]
    after = {one: one.stat().st_size for one in client.studio.store.folder.rglob("*")}
    assert after == before
    assert client.studio.store.bytes == count


def test_all_uploads_together_are_bounded(client, page, other):
    noise = np.random.default_rng(0).integers(0, 255, (8, 500, 500, 3)).astype(np.uint8)
    pictures = [png_bytes(one) for one in noise]
    tabs = zip(pictures, [page, other] * 4, strict=True)
    statuses = [tab.ask("POST", "uploads", content=one).status_code for one, tab in tabs]
    assert statuses.count(200) == client.studio.limits.stored_bytes // len(pictures[0])
    assert set(statuses) == {200, 413}
    assert client.studio.store.bytes == stored(client) <= client.studio.limits.stored_bytes


def test_an_upload_whose_file_is_gone_is_not_there(client, page):
    upload = page.upload(png(0))["id"]
    (path,) = client.studio.store.folder.glob(f"*/{upload}.png")
    path.unlink()
    assert page.ask("GET", f"uploads/{upload}").status_code == 404
    assert page.refused("materials", {"maps": {"color": upload}}, 404)


def test_one_picture_is_decoded_at_a_time(client, page, monkeypatch):
    """Eight small files can take a gigabyte each; uploads wait, and small requests do not."""
    now, most, real = [], [], uploads.read_image

    def decode(*values, **how):
        now.append(1)
        most.append(len(now))
        time.sleep(0.05)
        now.pop()
        return real(*values, **how)

    monkeypatch.setattr(uploads, "read_image", decode)
    answers = at_once(page, [("POST", "uploads", png(k)) for k in range(8)])
    specs = [color(answer.json()) for answer in answers]
    assert codes(at_once(page, [("POST", "materials", spec) for spec in specs])) == [200] * 8
    assert (len(most), max(most)) == (16, 1)


def test_a_second_studio_leaves_what_is_open(client, page, monkeypatch):
    """Both mark what they have open as used, however old it is."""
    monkeypatch.setattr(app, "_MARK", 1)
    upload, ticket = page.upload(png(0)), page.post(f"results/{made(page)[0]}/exports")["ticket"]
    folder = client.studio.store.folder
    (own,) = (one.parent for one in folder.glob(f"*/{upload['id']}.png"))
    for one in (own, client.studio.downloads.folder):
        os.utime(one, (0, 0))
    end = time.monotonic() + 60
    while min(own.stat().st_mtime, client.studio.downloads.folder.stat().st_mtime) == 0:
        assert time.monotonic() < end
        time.sleep(0.05)
    Studio(folder, replace(SMALL)).close()
    assert page.get(f"uploads/{upload['id']}") == png(0)
    assert client.get(f"/api/downloads/{ticket}").status_code == 200
