"""Methods by their names, and as texts: a slug, then parameters."""

from __future__ import annotations

import dataclasses
import shlex
from collections.abc import Mapping
from typing import Any

from weftex.errors import InvalidInputError, shown, wrong_value
from weftex.method import Method
from weftex.parameters import kind_of
from weftex.registry import AUTO, METHODS, method_class, owners

__all__ = ["is_auto", "make_method", "method_for_task", "parse_method", "text_of"]


def is_auto(method: str | Method) -> bool:
    """Whether "auto" is meant, by name or as an object."""
    return isinstance(method, Method | str) and getattr(method, "slug", method) == AUTO


def make_method(method: str | Method, parameters: Mapping[str, Any]) -> Method:
    """Return the method of this slug, or "auto", with these parameters.

    Errors name the nearest right name, and the methods that have a parameter which "auto" chooses.
    """
    if isinstance(method, Method):
        return dataclasses.replace(method, **parameters)
    if not isinstance(method, str):
        raise wrong_value("method", method, "a name or a Method")
    found = method_class(method)
    for name in parameters if method == AUTO else ():
        able = ", ".join(owners(name))
        if able and name not in (field.name for field in dataclasses.fields(found)):
            raise InvalidInputError(f"auto has no parameter '{name}'; these methods do: {able}")
    made: Method = found(**parameters)
    return made


def method_for_task(
    task: str, default: str, method: str | Method, parameters: Mapping[str, Any]
) -> Method:
    """Return the method of a task, which has a default in place of "auto"."""
    if not is_auto(method):
        return make_method(method, parameters)
    if isinstance(method, Method) and method != type(method)():
        raise InvalidInputError(f"effort has no effect on {task}")
    return make_method(default, parameters)


def parse_method(text: str) -> Method:
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
    """The text that `parse_method` reads back: slug and parameters that are not defaults."""
    words = [method.slug]
    for field in dataclasses.fields(method):
        value = getattr(method, field.name)
        if value != field.default:
            value = ",".join(map(str, value)) if field.metadata["count"] else value
            words.append(shlex.quote(f"{field.name}={value}"))
    return " ".join(words)
