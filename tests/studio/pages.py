"""A page without a browser: what the studio's own page sends, and what others try."""

import http.client
import json
import re
import subprocess
import sys
import time
from dataclasses import dataclass
from io import BytesIO
from urllib.parse import quote

import numpy as np
from PIL import Image

from weftex.io.pictures import write_image

ENDED = ("done", "failed", "cancelled")


@dataclass(frozen=True)
class Answer:
    status_code: int
    headers: dict
    content: bytes

    @property
    def text(self):
        return self.content.decode("utf-8", "replace")

    def json(self):
        return json.loads(self.content)


class Client:
    """Whoever sends requests to a server on the loopback."""

    def __init__(self, port, studio=None):
        self.port, self.studio = port, studio
        self.host = f"127.0.0.1:{port}"
        self.origin = f"http://{self.host}"

    def page(self):
        """A new tab."""
        return Page(self, self.studio.token)

    def request(self, method, path, headers=(), content=None):
        """One request; headers may be pairs, of which some are there twice."""
        pairs = list(headers.items() if isinstance(headers, dict) else headers)
        if "host" not in [name.lower() for name, _ in pairs]:
            pairs.insert(0, ("host", self.host))
        line = http.client.HTTPConnection("127.0.0.1", self.port, timeout=60)
        try:
            line.putrequest(method, path, skip_host=True, skip_accept_encoding=True)
            for name, value in pairs:
                line.putheader(name, value)
            if isinstance(content, str):
                content = content.encode()
            if isinstance(content, (bytes, bytearray)):
                line.putheader("content-length", str(len(content)))
                line.endheaders(content)
            elif content is not None:  # in pieces, whose number nobody knows before
                line.putheader("transfer-encoding", "chunked")
                line.endheaders(content, encode_chunked=True)
            else:
                line.endheaders()
            answer = line.getresponse()
            found = {name.lower(): value for name, value in answer.getheaders()}
            return Answer(answer.status, found, answer.read())
        finally:
            line.close()

    def get(self, path, headers=()):
        return self.request("GET", path, headers)


class Page:
    """One tab."""

    def __init__(self, client, token, session=None):
        self.client, self.token = client, token
        self.headers = {"x-weftex-token": token}
        self.start = self.post("session", {"session": session})
        self.headers["x-weftex-session"] = self.start["session"]

    @property
    def session(self):
        """The session as the server has it."""
        return self.client.studio.session(self.start["session"])

    def ask(self, method, path, **more):
        headers = self.headers | {"origin": self.client.origin} | more.pop("headers", {})
        headers = {name: value for name, value in headers.items() if value is not None}
        return self.client.request(method, f"/api/{path}", headers=headers, **more)

    def get(self, path):
        answer = self.ask("GET", path)
        assert answer.status_code == 200, answer.text
        plain = answer.headers["content-type"].startswith("application/json")
        return answer.json() if plain else answer.content

    def post(self, path, body=None, status=(200, 201)):
        answer = self.ask("POST", path, content=json.dumps({} if body is None else body))
        assert answer.status_code in status, answer.text
        return answer.json()

    def refused(self, path, body, status=422):
        """The line that a request is refused with."""
        answer = self.post(path, body, (status,))
        assert "\n" not in answer["error"]
        return answer

    def upload(self, content, name="photo.png", status=(200,)):
        named = {"x-weftex-name": quote(name)}
        answer = self.ask("POST", "uploads", content=content, headers=named)
        assert answer.status_code in status, answer.text
        return answer.json()

    def upload_pixels(self, pixels, folder, name="photo.png", **how):
        file = folder / f"upload{name[-4:]}"
        write_image(file, pixels, **how)
        return self.upload(file.read_bytes(), name)["id"]

    def job(self, recipe, path="jobs", **more):
        """A job that has ended."""
        return self.wait(self.post(path, {"recipe": recipe, **more}))

    def wait(self, job, states=ENDED, seconds=300):
        end = time.monotonic() + seconds
        while job["state"] not in states:
            assert time.monotonic() < end, job
            job = self.get(f"jobs/{job['id']}?seen={job['version']}&wait=5")
        return job

    def found(self, path, body=None):
        """The only result of a job that a path queues."""
        job = self.wait(self.post(path, body))
        assert job["state"] == "done", job
        return job["results"][0]

    def look(self, material):
        """What analysis says about a material."""
        return self.found(f"materials/{material}/look")

    def made(self, recipe, **more):
        """The only result of a job."""
        job = self.job(recipe, **more)
        assert job["state"] == "done", job
        (result,) = job["results"]
        return result

    def pixels(self, path):
        """The picture that a path answers with."""
        return np.array(Image.open(BytesIO(self.get(path))))

    def taken(self, path, **wanted):
        """The bytes of what is exported, and its name."""
        ticket = self.post(f"{path}/exports", wanted)
        answer = self.client.get(f"/api/downloads/{ticket['ticket']}")
        assert answer.status_code == 200
        assert len(answer.content) == ticket["bytes"]
        return answer.content, ticket["name"]


class Process:
    """The command in a process of its own."""

    def __init__(self, folder, *words, browser=False):
        words = ["studio", *words, "--data", str(folder), *([] if browser else ["--no-browser"])]
        command = [sys.executable, "-c", "from weftex.cli import entry; entry()", *words]
        self.run = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
        line = next(line for line in self.run.stderr if "http://" in line)
        port, self.token = re.search(r"http://127\.0\.0\.1:(\d+)/#token=(\S+)", line).groups()
        self.client = Client(int(port))

    def end(self, number):
        self.run.send_signal(number)
        with self.run.stderr:
            return self.run.wait(60)
