"""The nodes in a real ComfyUI: WEFTEX_COMFYUI is a folder with a copy of it."""

from __future__ import annotations

import json
import os
import shutil
import socket
import subprocess
import sys
import time
import urllib.error
import urllib.request
from pathlib import Path

import numpy as np
import pytest
import weftex_comfyui

from weftex import cli
from weftex.io.pictures import read_image, write_image

COMFYUI = os.environ.get("WEFTEX_COMFYUI")
NODES = Path(weftex_comfyui.__file__).parent
WORKFLOWS = NODES / "example_workflows"

pytestmark = pytest.mark.skipif(not COMFYUI, reason="WEFTEX_COMFYUI names no copy of ComfyUI")


class Server:
    """A ComfyUI with folders of its own."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        for name in ("custom_nodes", "input", "output", "temp", "user"):
            (folder / name).mkdir()
        shutil.copytree(NODES, folder / "custom_nodes" / NODES.name)
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.port = free.getsockname()[1]
        words = ["--cpu", "--listen", "127.0.0.1", "--port", str(self.port)]
        words += ["--disable-auto-launch", "--disable-api-nodes", "--base-directory", str(folder)]
        self.log = (folder / "log").open("w+")
        self.process = subprocess.Popen(
            [sys.executable, f"{COMFYUI}/main.py", *words], stdout=self.log, stderr=self.log
        )
        end = time.monotonic() + 300
        while self.process.poll() is None and time.monotonic() < end:
            try:
                self.ask("/system_stats")
                return
            except (urllib.error.URLError, ConnectionError):
                time.sleep(0.5)
        self.stop()
        raise RuntimeError((folder / "log").read_text())

    def ask(self, path, given=None):
        data = None if given is None else json.dumps(given).encode()
        request = urllib.request.Request(f"http://127.0.0.1:{self.port}{path}", data)
        with urllib.request.urlopen(request, timeout=60) as answer:
            text = answer.read()
        return json.loads(text) if text else None

    def start(self, workflow):
        """Queue a workflow; return its id."""
        return self.ask("/prompt", {"prompt": workflow})["prompt_id"]

    def wait(self, number):
        """Return the status of a workflow when it has ended."""
        end = time.monotonic() + 300
        while time.monotonic() < end:
            if found := self.ask(f"/history/{number}"):
                return found[number]["status"]
            time.sleep(0.1)
        raise TimeoutError(number)

    def stop(self):
        self.process.terminate()
        self.process.wait(60)
        self.log.close()


@pytest.fixture(scope="module")
def server(tmp_path_factory):
    made = Server(tmp_path_factory.mktemp("comfyui"))
    yield made
    made.stop()


def workflow(name):
    return json.loads((WORKFLOWS / "api" / f"{name}.json").read_text())


def test_every_node_is_there(server):
    found = server.ask("/object_info")
    for name in weftex_comfyui.NODE_CLASS_MAPPINGS:
        assert found[name]["category"] == "weftex" and found[name]["description"]


def test_a_set_has_the_bytes_of_the_command_line(server, tmp_path):
    assert server.wait(server.start(workflow("tileable_material")))["status_str"] == "success"
    words = ["synth", "sample:stone_wall", "-o", str(tmp_path / "wall"), "--size", "512x384"]
    words += ["--tileable", "--seed", "7", "--preset", "ambientcg", "--quiet"]
    assert cli.main(words) == 0
    made = {p.name: p.read_bytes() for p in (server.folder / "output/weftex/wall_00001_").iterdir()}
    assert made == {p.name: p.read_bytes() for p in (tmp_path / "wall").iterdir()}
    assert len(made) == 5


def test_a_picture_has_the_pixels_of_the_command_line(server, tmp_path):
    photo = read_image("sample:leaves").pixels[:150, :170]
    write_image(server.folder / "input" / "example.png", photo)
    assert server.wait(server.start(workflow("make_tileable")))["status_str"] == "success"
    given, even, out = (
        server.folder / "input/example.png",
        tmp_path / "even.png",
        tmp_path / "a.png",
    )
    assert cli.main(["prepare", str(given), "-o", str(even), "--even-light", "--quiet"]) == 0
    assert cli.main(["tile", str(even), "-o", str(out), "--seed", "1", "--quiet"]) == 0
    made = read_image(server.folder / "output/weftex/tileable_00001_.png").pixels
    np.testing.assert_array_equal(made, read_image(out).pixels)


def test_a_run_is_interrupted(server):
    long = workflow("tileable_material")
    long["2"]["inputs"] |= {"method": "efros-leung", "width": 3000, "height": 3000}
    before = sorted(server.folder.glob("output/**/*"))
    number = server.start(long)
    while not server.ask("/queue")["queue_running"]:
        time.sleep(0.1)
    time.sleep(1)
    server.ask("/interrupt", {})
    status = server.wait(number)  # much less long than the run
    assert "execution_interrupted" in [name for name, _ in status["messages"]]
    assert sorted(server.folder.glob("output/**/*")) == before


def test_an_error_is_that_of_weftex(server):
    wrong = workflow("tileable_material")
    wrong["2"]["inputs"] |= {"method": "quilting", "parameters": "patchsize=5"}
    status = server.wait(server.start(wrong))
    told = dict(status["messages"])["execution_error"]["exception_message"]
    assert "patch_size" in told and told.strip().count("\n") == 0


@pytest.mark.parametrize("folder", ["..", "../output", "/etc"])
def test_folders_outside_are_refused(server, folder):
    wrong = workflow("tileable_material")
    wrong["1"]["inputs"]["folder"] = folder
    with pytest.raises(urllib.error.HTTPError, match="400"):
        server.start(wrong)


def test_files_outside_are_not_written(server):
    wrong = workflow("tileable_material")
    wrong["3"]["inputs"]["filename_prefix"] = "../../elsewhere/wall"
    assert server.wait(server.start(wrong))["status_str"] == "error"
    assert not (server.folder.parent / "elsewhere").exists()


@pytest.mark.parametrize("name", ["tileable_material", "make_tileable"])
def test_both_forms_of_an_example_are_the_same(name):
    """The form of the page has the nodes, links and values of that for `/prompt`."""
    page = json.loads((WORKFLOWS / f"{name}.json").read_text())
    sources = {link[0]: [str(link[1]), link[2]] for link in page["links"]}
    for node in page["nodes"]:
        own = workflow(name)[str(node["id"])]
        assert node["type"] == own["class_type"]
        links = {one["name"]: sources[one["link"]] for one in node["inputs"] if one.get("link")}
        assert links == {k: v for k, v in own["inputs"].items() if isinstance(v, list)}
        values = [v for v in own["inputs"].values() if not isinstance(v, list)]
        assert all(value in node["widgets_values"] for value in values)
