"""The server's socket and address, which are known before the server itself is there.

A browser that is told the address waits for the answer, so it can start meanwhile.
"""

from __future__ import annotations

import shutil
import socket
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from weftex.errors import FileError
from weftex.studio.downloads import Downloads

#: Tried first, so that a page that is open finds the server again after a restart.
PORT = 8427
_HOST = "127.0.0.1"  # nothing but this machine


def listen(port: int | None) -> socket.socket:
    """Return a socket that listens to this machine; a `port` of None is `PORT`, or any free one.

    Raises `FileError` if it cannot.
    """
    tried = [PORT, 0] if port is None else [port]
    for one in tried:
        found = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
        found.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            found.bind((_HOST, one))
            found.listen(128)
        except (OSError, OverflowError) as error:
            found.close()
            if one == tried[-1]:
                why = getattr(error, "strerror", None) or error
                raise FileError(f"cannot listen at {_HOST}:{one}: {why}") from None
        else:
            return found
    raise AssertionError


def hosts_of(port: int) -> set[str]:
    """Return what the Host header of a request may be."""
    names = {_HOST, "localhost"}
    return {f"{name}:{port}" for name in names} | (names if port == 80 else set())


def address_of(listener: socket.socket, token: str) -> str:
    """Return what is to be opened in a browser."""
    return f"http://{_HOST}:{listener.getsockname()[1]}/#token={token}"


@contextmanager
def redirect_file(address: str, downloads: Downloads) -> Iterator[Path]:
    """Yield a page, for its owner alone, that leads to the address; it is removed afterwards."""
    text = '<!doctype html><meta charset="utf-8"><meta name="referrer" content="no-referrer">'
    text += f'<title>weftex</title><meta http-equiv="refresh" content="0; url={address}">'
    with downloads.new_folder() as folder:
        try:
            file = folder / "open.html"
            file.touch(mode=0o600)
            file.write_text(text, "utf-8")
            yield file
        finally:
            shutil.rmtree(folder, ignore_errors=True)
