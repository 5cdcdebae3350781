"""Connections that send nothing, or slowly, are closed; the owner is answered meanwhile."""

import socket
import time
from contextlib import suppress
from dataclasses import replace

import pytest
from pages import Client, Page
from test_jobs import QUICK

from conftest import SMALL, serving
from weftex.studio.studio import Studio

SECONDS = 1.5


@pytest.fixture(scope="module")
def client(tmp_path_factory):
    limits = replace(SMALL, header_seconds=SECONDS, strangers=16, requests=20)
    studio = Studio(tmp_path_factory.mktemp("data") / "studio", limits)
    with serving(studio) as server:
        yield Client(server.listener.getsockname()[1], studio)


def connect(client, text=b""):
    line = socket.create_connection(("127.0.0.1", client.port), timeout=20)
    line.sendall(text)
    return line


def closed_after(line):
    """The seconds until the other side closes a connection."""
    start = time.monotonic()
    with suppress(ConnectionResetError):
        while line.recv(2**16):
            pass
    return time.monotonic() - start


@pytest.mark.parametrize("sent", [b"", b"GET / HTTP/1.1\r\n", b"GET / HTTP/1.1\r\nx-long: "])
def test_a_request_that_does_not_come_is_not_waited_for(client, sent):
    with connect(client, sent) as line:
        assert 0.5 * SECONDS < closed_after(line) < 3 * SECONDS


@pytest.mark.parametrize("before", [0, 1])
def test_headers_that_come_slowly_are_not_waited_for(client, before):
    """Neither those of the first request of a connection, nor of the second."""
    whole = f"GET / HTTP/1.1\r\nhost: {client.host}\r\n\r\n".encode()
    start = time.monotonic()
    with connect(client, before * whole + b"G") as line:
        with suppress(ConnectionError):
            while time.monotonic() < start + 4 * SECONDS:
                line.sendall(b"E")
                time.sleep(0.1)
        assert 0.5 * SECONDS < time.monotonic() - start < 3 * SECONDS


@pytest.mark.parametrize("sent", [b"", b"GET /static/app.js HTTP/1.1\r\nhost: HOST\r\n\r\n"])
def test_strangers_cannot_shut_out_the_owner(client, sent):
    """By 220 connections that stay open, and open again as often as they like."""
    sent = sent.replace(b"HOST", client.host.encode())
    page = Page(client, client.studio.token)
    lines = []
    for _ in range(4):
        lines += [connect(client, sent) for _ in range(55)]
        assert page.ask("GET", "jobs").status_code == 200
    assert client.get("/").status_code == 200
    for line in lines:
        line.close()


def test_a_connection_with_the_token_stays(client):
    page = Page(client, client.studio.token)
    head = "".join(f"{name}: {value}\r\n" for name, value in page.headers.items())
    request = f"GET /api/jobs HTTP/1.1\r\nhost: {client.host}\r\n{head}\r\n".encode()
    with connect(client, request) as own, own.makefile("rb") as answers:
        first = list(iter(answers.readline, b"\r\n")), answers.read(2)
        lines = [connect(client) for _ in range(60)]
        own.sendall(request)
        second = list(iter(answers.readline, b"\r\n")), answers.read(2)
        assert first[0][0] == second[0][0] == b"HTTP/1.1 200 OK\r\n"
        for line in lines:
            line.close()


def test_a_long_answer_is_not_cut(client):
    """The time for headers is not that of an answer that somebody waits for."""
    page = Page(client, client.studio.token)
    job = page.job(QUICK)
    start = time.monotonic()
    page.get(f"jobs/{job['id']}?seen={job['version']}&wait=3")
    assert time.monotonic() - start > 2 * SECONDS - 0.2
