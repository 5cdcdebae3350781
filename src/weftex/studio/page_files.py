"""The files of the page."""

from __future__ import annotations

from functools import cache
from importlib.resources import files
from importlib.resources.abc import Traversable

_TYPES = {
    "html": "text/html; charset=utf-8",
    "css": "text/css; charset=utf-8",
    "js": "text/javascript; charset=utf-8",
    "json": "application/json",
    "svg": "image/svg+xml",
}


@cache
def static_files() -> dict[str, tuple[Traversable, str]]:
    """Return every file and its type by its name, with slashes."""
    found: dict[str, tuple[Traversable, str]] = {}
    waiting = [("", files("weftex.studio") / "static")]
    while waiting:
        folder, place = waiting.pop()
        for one in place.iterdir():
            name = folder + one.name
            kind = _TYPES.get(one.name.rpartition(".")[2])
            if one.is_dir():
                waiting.append((f"{name}/", one))
            elif kind is not None:
                found[name] = one, kind
    return found
