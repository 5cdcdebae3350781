"""Work in a queue: progress, previews, cancelling, and what becomes of it when its page goes."""

import socket
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from pages import ENDED

from conftest import serving
from weftex.io.pictures import read_image
from weftex.io.png import SIGNATURE, png_bytes

BRICKS = {"sample": "bricks"}
QUICK = {"materials": [BRICKS], "size": [64, 64], "seed": 1, "method": "quilting"}
#: Twenty seconds, if nobody stops it.
LONG = {"materials": [BRICKS], "size": [64, 64], "seed": 1, "method": "sleepy"}


def idle(client):
    """Whether nothing runs or waits, after a moment."""
    end = time.monotonic() + 60
    while any(job.state not in ENDED for job in list(client.studio.jobs._jobs.values())):
        if time.monotonic() > end:
            return False
        time.sleep(0.02)
    return True


def test_progress_previews_and_an_end(client, page):
    job = page.post("jobs", {"recipe": LONG})
    assert job["state"] in ("waiting", "running")
    versions, preview = [job["version"]], 0
    while preview < 2:
        job = page.get(f"jobs/{job['id']}?seen={job['version']}&wait=5")
        assert job["version"] > versions[-1]
        versions.append(job["version"])
        if job["preview"] > preview:
            preview = job["preview"]
            answer = page.ask("GET", f"jobs/{job['id']}/preview")
            assert answer.content.startswith(SIGNATURE)
            assert answer.headers["x-weftex-width"] == "256"
    assert job["total"] > job["done"] > 0 and job["stage"] and job["seconds"] > 0
    assert job["recipe"]["method"] == "sleepy"  # by which a page that comes back takes it up
    page.ask("DELETE", f"jobs/{job['id']}")
    job = page.wait(job)
    assert (job["state"], job["results"], job["error"]) == ("cancelled", [], None)
    assert idle(client)


def test_an_analysis_counts_and_can_be_stopped(client, page, tmp_path):
    pixels = np.random.default_rng(1).integers(0, 256, (384, 384, 3), np.uint8)
    spec = {"maps": {"color": page.upload_pixels(pixels, tmp_path)}}
    path = f"materials/{page.post('materials', spec)['id']}/look"
    job = page.wait(page.post(path), states=("running", *ENDED))
    job = page.get(f"jobs/{job['id']}?seen={job['version']}&wait=5")
    assert (job["stage"], job["total"], job["state"]) == ("analysis", 100, "running")
    page.ask("DELETE", f"jobs/{job['id']}")
    assert page.wait(job)["state"] == "cancelled" and idle(client)
    assert page.look(path.split("/")[1])["scale"] > 0


def test_waiting_for_news_takes_no_longer_than_asked(client, page):
    job = page.job(QUICK)
    ask = f"jobs/{job['id']}?seen={job['version']}&wait="
    with ThreadPoolExecutor(1) as pool:
        other = pool.submit(page.get, f"{ask}20")
        start = time.monotonic()
        same = page.get(f"{ask}1")
        assert time.monotonic() - start > 0.9 and not other.done()
        assert same["version"] == job["version"]
        assert page.get(f"jobs/{job['id']}?seen=0&wait=20") == same
        client.studio.jobs.get(job["id"], page.session).version += 1
        assert other.result()["version"] == job["version"] + 1


def test_nine_seeds(page):
    job = page.job(QUICK, each=[{"seed": seed} for seed in range(1, 10)])
    assert [one["recipe"]["seed"] for one in job["results"]] == list(range(1, 10))
    assert len({page.get(f"results/{one['id']}/picture") for one in job["results"]}) == 9
    for wrong in ([{}] * 17, ["seed"], 9):
        assert page.refused("jobs", {"recipe": QUICK, "each": wrong})["parameter"] == "each"


def test_methods_side_by_side(page):
    guide = page.upload(png_bytes(read_image("sample:bricks").pixels[:64, :64]))["id"]
    plain = {"materials": [BRICKS], "size": [64, 64], "seed": 1}
    each = [{"method": "quilting"}, {"method": "ashikhmin"}]
    found = page.job({**plain, "guide": guide}, each=each, compare=True)["results"]
    assert "does not support following a guide" in found[0]["error"]
    assert [one["method"] for one in found] == ["quilting", "ashikhmin"]
    assert found[1]["figures"]["score"] > 0 and found[1]["seconds"] > 0
    line = page.refused("jobs", {"recipe": plain, "each": [{"method": "no"}]})["error"]
    assert line.startswith("unknown")


def test_a_job_ends_the_one_before_it_in_its_lane(client, page):
    first = page.post("jobs", {"recipe": LONG, "lane": "preview"})
    page.wait(first, ("running",))
    kept = page.post("jobs", {"recipe": LONG, "lane": "other"})
    last = page.post("jobs", {"recipe": QUICK, "lane": "preview"})
    assert page.wait(first)["state"] == "cancelled"
    assert page.wait(last)["state"] == "done"
    assert page.get(f"jobs/{kept['id']}")["state"] in ("waiting", "running")
    page.post("leave")
    assert page.wait(kept)["state"] == "cancelled"


def test_sliders_do_not_wait_for_long_work(client, page):
    for _ in range(3):
        page.post("jobs", {"recipe": LONG})
    assert page.job(QUICK, lane="preview")["state"] == "done"
    page.post("leave")
    assert idle(client)


def test_the_queue_is_bounded(client, page, other):
    own = [page.post("jobs", {"recipe": LONG})["id"] for _ in range(5)]
    assert "jobs are waiting" in page.refused("jobs", {"recipe": QUICK}, 429)["error"]
    other.post("jobs", {"recipe": LONG})
    assert other.refused("jobs", {"recipe": QUICK}, 429)
    assert max(page.get(f"jobs/{one}")["ahead"] for one in own) >= 2
    for tab in (page, other):
        tab.post("leave")
    assert idle(client)


def test_errors_are_told_beside_their_field(page):
    wrong = {**QUICK, "method": "near-regular", "parameters": {"lattice": [300, 0, 0, 300]}}
    job = page.job(wrong)
    assert (job["state"], job["parameter"], job["error"][:8]) == ("failed", "lattice", "lattice ")


@pytest.fixture(scope="module")
def short(tmp_path_factory):
    """A server that does not wait long for a page that has gone."""
    with serving(tmp_path_factory.mktemp("short"), away_seconds=0.5) as found:
        yield found


def test_a_page_that_goes_takes_its_work_with_it_or_not(short):
    page, other = short.page(), short.page()
    stays = other.post("jobs", {"recipe": {**LONG, "seed": 2}, "keep": True})["id"]
    gone = short.studio.jobs.get(page.post("jobs", {"recipe": LONG})["id"], page.session)
    end = time.monotonic() + 60
    while gone.state != "cancelled":  # asked here, as a page that asks is there
        assert time.monotonic() < end
        time.sleep(0.1)
    other.post("leave")
    assert other.get(f"jobs/{stays}")["state"] == "running"
    other.ask("DELETE", f"jobs/{stays}")
    assert idle(short)


def test_a_line_that_is_cut_in_the_middle_of_a_job(short):
    """A browser that was killed: its long poll ends without a word."""
    page = short.page()
    job = page.post("jobs", {"recipe": LONG})
    head = "".join(f"{name}: {value}\r\n" for name, value in page.headers.items())
    for _ in range(5):
        line = socket.create_connection(("127.0.0.1", short.port))
        path = f"/api/jobs/{job['id']}?seen=100000&wait=20"
        line.sendall(f"GET {path} HTTP/1.1\r\nhost: {short.host}\r\n{head}\r\n".encode())
        time.sleep(0.1)
        line.close()
    assert idle(short)
    assert page.get(f"jobs/{job['id']}")["state"] == "cancelled"
