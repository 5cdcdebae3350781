"""Connections that send nothing, or slowly, are closed; the owner is answered meanwhile."""

import socket
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress

import pytest
from test_jobs import QUICK

from conftest import serving

SECONDS = 1.5


@pytest.fixture(scope="module")
def client(tmp_path_factory):
    limits = {"header_seconds": SECONDS, "body_seconds": 4 * SECONDS, "strangers": 16}
    with serving(tmp_path_factory.mktemp("data"), **limits) as found:
        yield found


def connect(client, text=b""):
    line = socket.create_connection(("127.0.0.1", client.port), timeout=20)
    line.sendall(text)
    return line


def head_of(client, page, request, length):
    """Headers with the token."""
    known = page.headers | {"host": client.host, "origin": f"http://{client.host}"}
    known["content-length"] = length
    lines = [f"{request} HTTP/1.1", *(f"{name}: {value}" for name, value in known.items())]
    return "\r\n".join([*lines, "", ""]).encode()


def closed_after(line, piece=b""):
    """The seconds until the other side closes a connection, to which pieces are sent meanwhile."""
    start = time.monotonic()
    line.settimeout(0.1)
    with suppress(ConnectionError):
        while time.monotonic() < start + 60:
            line.sendall(piece)
            with suppress(TimeoutError):
                if not line.recv(2**16):
                    break
        else:
            pytest.fail("it stays open")
    return time.monotonic() - start


@pytest.mark.parametrize("sent", [b"", b"GET / HTTP/1.1\r\n", b"GET / HTTP/1.1\r\nx-long: "])
def test_a_request_that_does_not_come_is_not_waited_for(client, sent):
    with connect(client, sent) as line:
        assert closed_after(line) > 0.5 * SECONDS


@pytest.mark.parametrize("before", [0, 1])
def test_headers_that_come_slowly_are_not_waited_for(client, before):
    """Neither those of the first request of a connection, nor of the second."""
    whole = f"GET / HTTP/1.1\r\nhost: {client.host}\r\n\r\n".encode()
    with connect(client, before * whole + b"G") as line:
        assert closed_after(line, b"E") > 0.5 * SECONDS


def test_a_body_that_does_not_come_is_not_waited_for(client, page):
    """Nor, though longer, one that comes byte by byte, though it has the token."""
    begun = head_of(client, page, "POST /api/jobs", 10000) + b"{"
    with ThreadPoolExecutor() as pool, connect(client, begun) as slow:
        comes = pool.submit(closed_after, slow, b"1")
        with connect(client, begun) as idle:
            assert closed_after(idle) > 0.5 * SECONDS and not comes.done()
        assert comes.result() > 2 * SECONDS


def test_an_upload_that_is_too_large_is_refused_before_it_comes(client, page):
    with connect(client, head_of(client, page, "POST /api/uploads", 10**11)) as line:
        assert line.recv(2**16).startswith(b"HTTP/1.1 413 ")
        line.sendall(b"x" * 2**20)  # as a browser does, which reads the answer after that
        closed_after(line)


@pytest.mark.parametrize("sent", [b"", b"GET /static/app.js HTTP/1.1\r\nhost: HOST\r\n\r\n"])
def test_strangers_cannot_shut_out_the_owner(client, page, sent):
    """By 220 connections that stay open, and open again as often as they like."""
    sent = sent.replace(b"HOST", client.host.encode())
    lines = []
    for _ in range(4):
        lines += [connect(client, sent) for _ in range(55)]
        assert page.ask("GET", "jobs").status_code == 200
    assert client.get("/").status_code == 200
    for line in lines:
        line.close()


def test_a_connection_with_the_token_stays(client, page):
    request = head_of(client, page, "GET /api/jobs", 0)
    with connect(client, request) as own, own.makefile("rb") as answers:
        first = list(iter(answers.readline, b"\r\n")), answers.read(2)
        lines = [connect(client) for _ in range(60)]
        own.sendall(request)
        second = list(iter(answers.readline, b"\r\n")), answers.read(2)
        assert first[0][0] == second[0][0] == b"HTTP/1.1 200 OK\r\n"
        for line in lines:
            line.close()


def test_a_long_answer_is_not_cut(client, page):
    """The time for headers is not that of an answer that somebody waits for."""
    job = page.job(QUICK)
    start = time.monotonic()
    page.get(f"jobs/{job['id']}?seen={job['version']}&wait=3")
    assert time.monotonic() - start > 2 * SECONDS - 0.2
