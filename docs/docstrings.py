"""For mkdocstrings: docstrings as the site can render them.

Parameters that share a line get one each, with its own part of a text whose parts are divided by
semicolons. `**` between numbers is no emphasis, public names are links, and the parameters of a
method's class are listed with their meaning, range and default.
"""

from __future__ import annotations

import dataclasses
import importlib
import re
from pathlib import Path
from typing import Any

from griffe import Class, Docstring, Extension, Function, Object

#: A line of a section that names several parameters, and what is said about them.
SHARED = re.compile(r"^(\w+(?:, (?:\*\*)?\w+)+)( :.*)?\n((?: +\S.*(?:\n|$)|\n(?= ))+)", re.M)
#: A line that is no code.
PROSE = re.compile(r"^(?! *(?:>>>|\.\.\.)).*", re.M)
PAGES = "".join(page.read_text("utf-8") for page in Path(__file__).parent.rglob("python/*.md"))
#: The place of each name that has an entry on the site.
ENTRIES = {path.rpartition(".")[2]: path for path in re.findall(r"^::: (\S+)$", PAGES, re.M)}


def split(found: re.Match[str]) -> str:
    """One entry for each name, with its own part of the text and of the type if they have parts."""
    names, kind, text = found[1].split(", "), found[2] or "", found[3]
    parts = " ".join(text.split()).removesuffix(".").split("; ")
    kinds = re.split(r", (?![^(]*\))", kind.removeprefix(" : "))
    if len(kinds) != len(names) or "optional" in kinds:
        kinds = [kind.removeprefix(" : ")] * len(names)
    own = [f"    {part[0].upper()}{part[1:]}." for part in parts]
    if len(own) != len(names):
        own = [text.rstrip()] * len(names)
    rows = zip(names, kinds, own, strict=True)
    return "".join(f"{name}{kind and f' : {one}'}\n{said}\n" for name, one, said in rows)


def linked(found: re.Match[str]) -> str:
    """A name with a link to its entry."""
    return f"[{found[0]}][{ENTRIES[found[1]]}]" if found[1] in ENTRIES else found[0]


def readable(found: re.Match[str]) -> str:
    """A line of text with links and powers."""
    line = re.sub(r"(?<=\w)\*\*(?=\w)", r"\\*\\*", found[0])
    return re.sub(r"`weftex\.(?:\w+\.)*(\w+)`", linked, line)


def parameters(cls: type) -> str:
    """The section of a method's parameters."""
    from weftex.cli.arguments import parameters_of

    rows = ["Parameters", "----------"]
    for field, values in parameters_of(cls):  # type: ignore[arg-type]
        text, values = (f"{one[0].upper()}{one[1:]}" for one in (field.metadata["help"], values))
        rows += [f"{field.name} : {field.type}", f"    {text}. *{values}.*"]
    return "\n".join(rows)


class Readable(Extension):
    """Changes docstrings before they are parsed."""

    def on_object(self, *, obj: Object, **_: Any) -> None:
        """Split shared lines and keep powers."""
        if obj.docstring:
            obj.docstring.value = PROSE.sub(readable, SHARED.sub(split, obj.docstring.value))

    def on_function(self, *, func: Function, **_: Any) -> None:
        """Show the values of defaults that are constants."""
        for parameter in func.parameters:
            if str(parameter.annotation) == "Seed":
                parameter.annotation = "int, numpy Generator or None"
            if re.fullmatch(r"_?[A-Z][A-Z_]+", str(parameter.default)):
                module = importlib.import_module(func.module.path)
                parameter.default = repr(getattr(module, str(parameter.default)))

    def on_class(self, *, cls: Class, **_: Any) -> None:
        """List the parameters of a method, with plain defaults in its signature."""
        declared = [m for m in cls.attributes.values() if str(m.value).startswith("parameter(")]
        if not declared:
            return
        method = getattr(importlib.import_module(cls.module.path), cls.name)
        for field in dataclasses.fields(method):
            cls.members["__init__"].parameters[field.name].default = repr(field.default)
        text = cls.docstring.value if cls.docstring else ""
        head, mark, rest = text.partition("\nExamples\n")
        cls.docstring = Docstring(
            f"{head.rstrip()}\n\n{parameters(method)}\n{mark}{rest}", parent=cls
        )
