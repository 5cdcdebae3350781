"""The files of weftex that a result depends on, and a name that changes when one of them does."""

from __future__ import annotations

import ast
import hashlib
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import weftex

HOME = Path(weftex.__file__).parent
_BY_NAME = {"METHODS", "make_method"}  # a module that imports one of these may call any method


@cache
def code_hash(*modules: str) -> str:
    """A name for the code of some modules of weftex and of all that they import.

    Examples
    --------
    >>> code_hash("weftex.methods.quilting") == code_hash("weftex.methods.quilting")
    True
    >>> code_hash("weftex.methods.quilting") == code_hash("weftex.methods.ashikhmin")
    False
    """
    found = hashlib.sha256()
    for file in files_of(*modules):
        found.update(f"{file.relative_to(HOME).as_posix()}\n".encode() + file.read_bytes())
    return found.hexdigest()


def files_of(*modules: str) -> list[Path]:
    """The files of these modules and of those that they import, in order."""
    found: set[Path] = set()
    todo = [file for module in modules for file in _files(module)]
    while todo:
        file = todo.pop()
        if file not in found:
            found.add(file)
            todo += _imported(file)
    beside = {file.with_suffix(".pxd") for file in found}
    return sorted(found | {file for file in beside if file.exists()})


def _files(module: str) -> list[Path]:
    """The file of a module or of a package of weftex, if the name is one's."""
    place = HOME.joinpath(*module.split(".")[1:])
    return [file for file in (place.with_suffix(".py"), place / "__init__.py") if file.exists()]


@cache
def _imported(file: Path) -> tuple[Path, ...]:
    """Files of the modules of weftex that a file imports, or calls by name."""
    tree = ast.parse(file.read_text(encoding="utf-8"))
    return tuple(found for name in _names(tree) for found in _files(name))


def _names(tree: ast.Module) -> Iterator[str]:
    for node in ast.walk(tree):
        names = []
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module:
            own = {alias.name for alias in node.names}
            names = [node.module, *(f"{node.module}.{name}" for name in own)]
            if node.module in ("weftex.naming", "weftex.registry") and own & _BY_NAME:
                yield from (f"weftex.methods.{one.stem}" for one in (HOME / "methods").iterdir())
        for name in names:
            name = name.removeprefix("cython.cimports.")
            if name.startswith("weftex."):
                yield name
