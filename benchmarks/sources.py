"""Which files of weftex a result hangs on: a name for them that changes when one of them does."""

from __future__ import annotations

import ast
import hashlib
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import weftex

HOME = Path(weftex.__file__).parent
_BY_NAME = {"METHODS", "make_method"}  # who asks for methods by name may get any


@cache
def code_hash(*modules: str) -> str:
    """A name for what modules of weftex are made of, with all that they import.

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
    todo = [HOME.joinpath(*module.split(".")[1:]).with_suffix(".py") for module in modules]
    while todo:
        file = todo.pop()
        if file not in found and file.exists():
            found.add(file)
            todo += _imported(file)
    beside = {file.with_suffix(".pxd") for file in found}
    return sorted(found | {file for file in beside if file.exists()})


@cache
def _imported(file: Path) -> tuple[Path, ...]:
    """Files of what it imports from weftex, or might."""
    return tuple(_candidates(ast.parse(file.read_text(encoding="utf-8"))))


def _candidates(tree: ast.Module) -> Iterator[Path]:
    for node in ast.walk(tree):
        names = []
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module:
            own = {alias.name for alias in node.names}
            names = [node.module, *(f"{node.module}.{name}" for name in own)]
            if node.module == "weftex.method" and own & _BY_NAME:
                yield from (HOME / "methods").glob("*.py")
        for name in names:
            parts = name.removeprefix("cython.cimports.").split(".")
            if parts[0] == "weftex" and len(parts) > 1:
                yield HOME.joinpath(*parts[1:]).with_suffix(".py")
