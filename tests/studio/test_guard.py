"""Who is let in: everything that another site, another tab or a wrong address may try."""

import re
from urllib.parse import quote

import numpy as np
import pytest

from weftex.studio import exports  # noqa: F401
from weftex.studio.app import static_files
from weftex.studio.guard import HEADERS
from weftex.studio.requests import ROUTES

CHANGING = [(method, path) for method, path, _ in ROUTES if method != "GET"]


@pytest.mark.parametrize(
    "host", ["evil.example", "evil.example:PORT", "127.0.0.1", "127.0.0.1:80", "8.8.8.8:PORT", ""]
)
def test_other_hosts_get_nothing(client, host):
    """A name of somebody's own that was made to point here: DNS rebinding."""
    for path in ("/", "/static/index.html", "/api/about", "/api/downloads/x"):
        name = host.replace("PORT", str(client.port))
        answer = client.get(path, {"host": name, "x-weftex-token": client.studio.token})
        assert answer.status_code == 403
        assert set(answer.json()) == {"error", "parameter"}


ORIGINS = ["null", "http://evil.example", "https://127.0.0.1", "http://127.0.0.1", "", "file://"]
ELSEWHERE = [("origin", one) for one in ORIGINS]
ELSEWHERE += [("sec-fetch-site", one) for one in ("cross-site", "same-site")]


@pytest.mark.parametrize(("header", "value"), ELSEWHERE)
def test_other_sites_get_nothing(client, header, value):
    headers = {header: value, "x-weftex-token": client.studio.token}
    for method, path in (("GET", "about"), ("GET", "session"), ("POST", "session")):
        answer = client.request(method, f"/api/{path}", headers)
        assert answer.status_code == 403, (method, path)


@pytest.mark.parametrize("token", [None, "", "wrong", "ü"])
def test_without_the_token_there_is_nothing(client, token):
    headers = {"origin": client.origin}
    headers |= {} if token is None else {"x-weftex-token": token.encode()}
    for method, path, _ in ROUTES:
        if path.startswith("/downloads"):
            continue
        answer = client.request(method, f"/api{path}", headers=headers)
        assert answer.status_code == 401, path


def test_two_headers_are_none(client):
    """What one program reads as the first and another as the last."""
    pairs = [("x-weftex-token", client.studio.token)]
    for name in ("origin", "x-weftex-token"):
        twice = [*pairs, (name, client.origin), (name, "http://evil.example")]
        assert client.get("/api/about", headers=twice).status_code in (401, 403)


@pytest.mark.parametrize(("method", "path"), CHANGING)
def test_what_changes_anything_needs_an_origin_and_is_no_get(client, page, method, path):
    assert page.ask(method, path[1:], headers={"origin": None}).status_code == 403
    before = (len(client.studio.sessions), client.studio.store.bytes)
    answer = page.ask("GET", path[1:], content=b"{}")
    assert answer.status_code in (400, 404, 405, 410) or ("GET", path) in [r[:2] for r in ROUTES]
    assert (len(client.studio.sessions), client.studio.store.bytes) == before
    assert client.studio.jobs.of(client.studio.session(page.start["session"])) == []


@pytest.mark.parametrize("method", ["PUT", "PATCH", "OPTIONS", "TRACE", "HEAD"])
def test_no_other_methods(page, method):
    assert page.ask(method, "session").status_code == 405


def test_every_answer_says_what_the_page_may_do(client, page):
    answers = [client.get("/"), page.ask("GET", "about"), client.get("/api/about")]
    answers += [client.get("/x"), client.get("/", headers={"host": "evil.example"})]
    for answer in answers:
        for name, value in HEADERS.items():
            assert answer.headers[name] == value
    assert HEADERS["content-security-policy"].startswith("default-src 'self'; ")


def test_there_are_no_websockets(client, page):
    asked = {"connection": "Upgrade", "upgrade": "websocket", "sec-websocket-version": "13"}
    asked |= {"sec-websocket-key": "dGhlIHNhbXBsZSBub25jZQ=="}
    assert page.ask("GET", "about", headers=asked).status_code == 200  # an answer, and no socket


@pytest.mark.parametrize(
    "name",
    ["../server.py", "..%2fserver.py", "%2e%2e/server.py", "/etc/passwd", "//etc/passwd",
     "..\\server.py", "index.html%00.js", "js/../../server.py", "", "."],
)  # fmt: skip
def test_names_of_files_are_no_paths(client, name):
    answer = client.get(f"/static/{name}")
    assert answer.status_code == 404, answer.text
    assert "import" not in answer.text


def test_the_page_is_there(client):
    for name, (place, kind) in static_files().items():
        answer = client.get(f"/static/{name}")
        assert answer.content == place.read_bytes()
        assert answer.headers["content-type"] == kind
    assert client.get("/").headers["content-type"].startswith("text/html")


def test_the_page_needs_nobody_else():
    for name, (place, _) in static_files().items():
        content = place.read_bytes()
        if name.endswith((".js", ".css", ".html")):
            named = re.findall(rb"https?://([^/\s:]+)", content)
            assert set(named) <= {b"www.w3.org", b"127.0.0.1"}, (name, named)
            assert content.count(b"\n") <= 400, name


NAMES = ["../../secret", "/etc/passwd", "sample:bricks", "a" * 64, "0" * 64, "%00", "..", "kept"]


@pytest.mark.parametrize("name", NAMES)
def test_ids_are_no_paths(page, name):
    word = quote(name, safe="")
    paths = [f"uploads/{word}", f"materials/{word}/picture", f"jobs/{word}", f"results/{word}"]
    paths += [f"planes/{word}/window", f"downloads/{word}", f"samples/{word}/picture"]
    for path in paths:
        assert page.ask("GET", path).status_code in (404, 410), path
    assert page.refused("materials", {"maps": {"color": name}}, 404)
    if name != "sample:bricks":
        assert page.refused("materials", {"sample": name})


MAPS = ["../x", "/tmp/x", "a/b", "..", ".x", "", "a\\b", "x" * 41, "a\0"]


@pytest.mark.parametrize("name", MAPS)
def test_names_of_maps_are_no_paths(page, name):
    """They become names of files in what is taken along."""
    given = {"maps": {"color": "0" * 64, name: "1" * 64}}
    assert page.refused("materials", given)["parameter"] == "maps"


@pytest.mark.parametrize(
    "old", ["../../etc", "x" * 43, "", 7, ["a"], None, "\0" * 43, "a/b" * 14 + "c"]
)
def test_a_session_that_is_none_is_a_new_one(page, client, old):
    before = {one.name for one in client.studio.store.folder.iterdir()}
    found = page.post("session", {"session": old})
    assert found["resumed"] is False
    assert found["session"] != old
    assert {one.name for one in client.studio.store.folder.iterdir()} == before


def test_tabs_do_not_see_each_other(page, other, tmp_path, rng):
    pixels = rng.integers(0, 255, (40, 40, 3)).astype(np.uint8)
    upload = page.upload_pixels(pixels, tmp_path)
    spec = {"maps": {"color": upload}}
    recipe = {"materials": [spec], "size": [48, 48], "seed": 1, "method": "quilting"}
    job = page.job(recipe)
    result = job["results"][0]["id"]
    page.post("steps", {"id": "a" * 12, "recipe": recipe, "result": result})
    material = page.post("materials", spec)["id"]
    plane = page.post("planes", {"materials": [{"sample": "weave"}], "method": "best-tile"})["id"]
    for path in (
        f"uploads/{upload}", f"jobs/{job['id']}", f"results/{result}/picture",
        f"planes/{plane}/window", f"materials/{material}/picture",
    ):  # fmt: skip
        assert page.ask("GET", path).status_code == 200, path
        assert other.ask("GET", path).status_code in (404, 410), path
    assert other.ask("DELETE", f"jobs/{job['id']}").status_code == 404
    assert other.refused("jobs", {"recipe": recipe}, 404)
    assert other.get("jobs") == other.session.steps == []
    assert [one["id"] for one in page.get("jobs")] == [job["id"]]
    answer = page.ask("GET", "about", headers={"x-weftex-session": None})
    assert answer.status_code == 200  # nobody's own
    assert page.ask("GET", "jobs", headers={"x-weftex-session": "x" * 43}).status_code == 401


@pytest.mark.parametrize(
    "wrong", [{"id": "../x"}, {"thumb": "data:text/html;base64,AA"}, {"recipe": {}}, {"parent": 3}]
)
def test_steps_that_no_page_writes_are_refused(page, wrong):
    step = {"id": "a" * 12, "recipe": {"materials": [{"sample": "bricks"}]}} | wrong
    assert page.refused("steps", step)["error"]
    for name in ("..", "%2e%2e", "steps", "0" * 64):
        assert page.ask("DELETE", f"works/{name}").status_code in (404, 405)
