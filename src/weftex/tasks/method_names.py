"""Methods by name, "auto" among them."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

from weftex import methods
from weftex.errors import InvalidInputError
from weftex.method import Method

__all__ = ["AUTO", "make_method"]

#: The name that stands for the method that suits the sample best.
AUTO = "auto"


def is_auto(method: str | Method) -> bool:
    """Whether "auto" is meant, by name or as an object."""
    name = getattr(method, "slug", method)
    return isinstance(name, str) and name == AUTO


def method_class(name: str) -> type[Method]:
    """Return the method of a slug, also of "auto", which is not in `METHODS`."""
    if name == AUTO:
        from weftex.tasks.auto import Auto  # only where it is wanted: it loads the analyses

        return Auto
    return methods.METHODS[name]


def make_method(method: str | Method, parameters: Mapping[str, Any]) -> Method:
    """Return the method of that slug, or "auto", with these parameters."""
    if is_auto(method):
        if isinstance(method, Method):
            return dataclasses.replace(method, **parameters) if parameters else method
        auto = method_class(AUTO)
        own = {field.name for field in dataclasses.fields(auto)}
        for name in parameters:
            able = ", ".join(methods.owners(name))
            if name not in own and able:
                raise InvalidInputError(
                    f"{AUTO} has no parameter '{name}'; these methods do: {able}"
                )
        return auto(**parameters)
    return methods.make_method(method, parameters)
