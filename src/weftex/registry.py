"""Every method by its slug but `auto`: ours, and methods of packages outside.

`weftex.methods` declares ours. A package outside adds its own by an entry point of the group
``weftex.methods``, whose name is the slug and whose object is the class.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cached_property
from importlib import import_module
from importlib.metadata import EntryPoint
from typing import Any

from weftex.errors import InvalidInputError, did_you_mean, shown

_GROUP = "weftex.methods"


class Registry(Mapping[str, type[Any]]):
    """Slug to class; a method's module is imported when it is asked for."""

    def __init__(self) -> None:
        self._homes: dict[str, str] = {}

    def declare(self, homes: Mapping[str, str]) -> None:
        """Add methods: slug to ``module:class``."""
        self._homes.update(homes)

    @cached_property
    def _outside(self) -> dict[str, EntryPoint]:
        """Those of other packages; one of our slugs stays ours."""
        from importlib.metadata import entry_points  # takes milliseconds, so only when needed

        found = entry_points(group=_GROUP)
        return {point.name: point for point in found if point.name not in self._homes}

    def __repr__(self) -> str:
        return f"<methods: {', '.join(self)}>"

    def __getitem__(self, slug: str) -> type[Any]:
        if isinstance(slug, str) and slug in self._homes:
            module, _, name = self._homes[slug].partition(":")
            ours: type[Any] = getattr(import_module(module), name)
            return ours
        if isinstance(slug, str) and slug in self._outside:
            theirs: type[Any] = self._outside[slug].load()
            return theirs
        if not isinstance(slug, str):
            raise InvalidInputError(f"method is {shown(slug)}; it must be a name")
        if slug == "auto":
            raise InvalidInputError(
                "'auto' is not a method, it chooses one: synthesize(..., method='auto')"
            )
        raise InvalidInputError(f"unknown method '{slug}'{did_you_mean(slug, ['auto', *self])}")

    def get(self, slug: str, default: Any = None) -> Any:
        """Return the method of that slug, or the default; a mapping's own `get` wants KeyError."""
        return self[slug] if slug in self else default  # noqa: SIM401

    def __contains__(self, slug: object) -> bool:
        return isinstance(slug, str) and (slug in self._homes or slug in self._outside)

    def __iter__(self) -> Iterator[str]:
        yield from self._homes
        yield from self._outside

    def __len__(self) -> int:
        return len(self._homes) + len(self._outside)


#: Every method by its slug.
METHODS = Registry()


def supporting(kind: str) -> list[str]:
    """Slugs of the methods that support a kind of canvas."""
    return [slug for slug in METHODS if kind in METHODS[slug].supports]
