"""The files of the page: for the server, and as one module for a notebook's widget."""

from __future__ import annotations

import json
import posixpath
import re
from functools import cache
from importlib.resources import files
from typing import TYPE_CHECKING

if TYPE_CHECKING:
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


_STYLES = ("base.css", "controls.css", "stage.css", "notebook.css")
_WORDS = ("stage.", "mode.", "role.", "overlay.", "see.", "light.", "time.", "close")
_IMPORT = re.compile(r'^import \{([^}]*)\} from "([^"]+)";\n', re.M)
_EXPORT = re.compile(r"^export ((?:async )?function|class|const) (\w+)", re.M)
#: Notebooks say whether they are dark in ways of their own; elsewhere the system says it.
_THEMES = """
:is([data-jp-theme-light="false"], [data-vscode-theme-kind*="dark"]) & { color-scheme: dark; }
:is([data-jp-theme-light="true"], [data-vscode-theme-kind*="light"]) & { color-scheme: light; }
"""


def _text(name: str) -> str:
    return (files("weftex.studio") / "static").joinpath(*name.split("/")).read_text("utf-8")


@cache
def module() -> str:
    """Return the widget's module: all modules that it needs in order, each as a function."""
    done: dict[str, str] = {}

    def add(name: str) -> None:
        if name in done:
            return
        folder, text = posixpath.dirname(name), _text(name)
        for _, path in _IMPORT.findall(text):
            add(posixpath.normpath(posixpath.join(folder, path)))

        def taken(found: re.Match[str]) -> str:
            path = posixpath.normpath(posixpath.join(folder, found[2]))
            return f"const {{{found[1]}}} = modules[{json.dumps(path)}];\n"

        given = ", ".join(name for _, name in _EXPORT.findall(text))
        body = _EXPORT.sub(r"\1 \2", _IMPORT.sub(taken, text)) + f"\nreturn {{ {given} }};"
        done[name] = f"modules[{json.dumps(name)}] = (() => {{\n{body}\n}})();\n"

    add("notebook.js")
    last = 'export default modules["notebook.js"].widget;\n'
    return "const modules = {};\n" + "".join(done.values()) + last


@cache
def styles() -> str:
    """Return the page's styles, for what lies in the widget alone."""
    inside = "\n".join(map(_text, _STYLES)).replace(":root", "&") + _THEMES
    return f".weftex-view {{\n{inside}}}\n"


@cache
def words() -> dict[str, str]:
    """Return the words of the views, in English."""
    known: dict[str, str] = json.loads(_text("strings/en.json"))
    return {key: text for key, text in known.items() if key.startswith(_WORDS)}
