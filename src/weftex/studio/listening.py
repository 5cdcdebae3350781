"""The server's socket and address, which are known before the server itself is there.

A browser that is told the address waits for the answer, so it can start meanwhile.
"""

from __future__ import annotations

import shutil
import socket
from contextlib import contextmanager
from typing import TYPE_CHECKING

from weftex.errors import FileError

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from weftex.studio.downloads import Downloads

#: Tried first, so that a page that is open finds the server again after a restart.
PORT = 8427
LOOPBACK = ("127.0.0.1", "localhost", "::1")


def listen(host: str, port: int | None) -> socket.socket:
    """Return a socket that listens; a `port` of None is `PORT`, or any that is free.

    Raises `FileError` if it cannot.
    """
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    tried = [PORT, 0] if port is None else [port]
    for one in tried:
        found = socket.socket(family, socket.SOCK_STREAM)
        found.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            found.bind((host, one))
            found.listen(128)
        except (OSError, OverflowError) as error:
            found.close()
            if one == tried[-1]:
                why = getattr(error, "strerror", None) or error
                raise FileError(f"cannot listen at {host}:{one}: {why}") from None
        else:
            return found
    raise AssertionError


def hosts_of(host: str, port: int) -> set[str]:
    """Return what the Host header of a request may be."""
    names = {*LOOPBACK, host} - {"0.0.0.0", "::"}
    if host in ("0.0.0.0", "::"):
        names |= {socket.gethostname(), *_addresses()}
    named = {f"[{name}]" if ":" in name else name for name in names}
    return {f"{name}:{port}" for name in named} | (named if port == 80 else set())


def _addresses() -> set[str]:
    try:
        return {str(one[4][0]) for one in socket.getaddrinfo(socket.gethostname(), None)}
    except OSError:
        return set()


def address_of(listener: socket.socket, host: str, token: str) -> str:
    """Return what is to be opened in a browser."""
    shown = "127.0.0.1" if host in ("0.0.0.0", "::", "localhost") else host
    shown = f"[{shown}]" if ":" in shown else shown
    return f"http://{shown}:{listener.getsockname()[1]}/#token={token}"


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
