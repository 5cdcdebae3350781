"""Methods by their names, and as texts: a slug, then parameters."""

from __future__ import annotations

import dataclasses
import shlex
from collections.abc import Mapping
from typing import Any

from weftex.errors import InvalidInputError, shown
from weftex.method import Method
from weftex.registry import METHODS

__all__ = ["kind_of", "make_method", "method_of", "text_of"]


def make_method(method: str | Method, parameters: Mapping[str, Any]) -> Method:
    """The method with this slug and parameters; errors name the nearest right name."""
    if not isinstance(method, (str, Method)):
        raise InvalidInputError(f"method is {shown(method)}; it must be a name or a Method")
    if isinstance(method, str):
        made: Method = METHODS[method](**parameters)
        return made
    return dataclasses.replace(method, **parameters)


def method_of(text: str) -> Method:
    """The method of a text such as 'graphcut placement=entire'; errors suggest the nearest name."""
    try:
        slug, *words = shlex.split(text)
    except ValueError:  # nothing, or a quotation without an end
        raise InvalidInputError(
            f"{shown(text)} is not a method; write it as 'NAME name=value'"
        ) from None
    given: dict[str, Any] = {}
    kinds = {field.name: kind_of(field) for field in dataclasses.fields(METHODS[slug])}
    for word in words:
        name, equals, value = word.partition("=")
        if not equals or name in given:
            raise InvalidInputError(
                f"{slug} has {shown(word)}; it must be name=value, once for each name"
            )
        try:
            given[name] = kinds.get(name, str)(value)
        except ValueError:
            given[name] = value  # which the method refuses with its own words
    return make_method(slug, given)


def text_of(method: Method) -> str:
    """The text that `method_of` reads back: slug and parameters that are not defaults."""
    words = [method.slug]
    for field in dataclasses.fields(method):
        value = getattr(method, field.name)
        if value != field.default:
            value = ",".join(map(str, value)) if field.metadata["count"] else value
            words.append(shlex.quote(f"{field.name}={value}"))
    return " ".join(words)


def kind_of(field: dataclasses.Field[Any]) -> type[int] | type[float] | type[str]:
    """What the text of a parameter is read as."""
    # A class where the method's module does not postpone its annotations, as ours do.
    wanted = getattr(field.type, "__name__", str(field.type)).split(" ")[0]
    return int if wanted == "int" else float if wanted == "float" else str
