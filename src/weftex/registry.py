"""Every method by its slug: ours, and methods of packages outside.

A package outside adds its own by an entry point of the group ``weftex.methods``, whose name is the
slug and whose object is the class.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import fields
from functools import cached_property
from importlib import import_module
from typing import TYPE_CHECKING, Any

from weftex.errors import InvalidInputError, did_you_mean, wrong_value

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

__all__ = ["AUTO", "FOR_FUSION", "FOR_HOLES", "FOR_TILES", "METHODS", "method_class"]

#: The slug of the method that chooses one for the sample; it is not listed in `METHODS`.
AUTO = "auto"
#: For holes with parameters or a sample of their own, or few pixels around; for tileable photos.
FOR_HOLES, FOR_TILES = "patch-sampling", "graphcut"
#: To fuse with parameters, and for regions of two mixed materials.
FOR_FUSION = "refinement"

_GROUP = "weftex.methods"
#: Modules and classes; a module is imported when its method is asked for.
_HOMES = {
    "patch-sampling": "methods.patch_sampling:PatchSampling",
    "quilting": "methods.quilting:Quilting",
    "graphcut": "methods.graphcut:GraphCut",
    "efros-leung": "methods.efros_leung:EfrosLeung",
    "wei-levoy": "methods.wei_levoy:WeiLevoy",
    "ashikhmin": "methods.ashikhmin:Ashikhmin",
    "exact-matching": "methods.exact_matching:ExactMatching",
    "refinement": "methods.refinement:Refinement",
    "best-tile": "methods.best_tile:BestTile",
    "near-regular": "methods.near_regular:NearRegular",
}


class Registry(Mapping[str, type[Any]]):
    """Slug to class."""

    @cached_property
    def _outside(self) -> dict[str, EntryPoint]:
        """Those of other packages; one of our slugs stays ours."""
        from importlib.metadata import entry_points  # takes milliseconds, so only when needed

        found = entry_points(group=_GROUP)
        return {point.name: point for point in found if point.name not in _HOMES}

    def __repr__(self) -> str:
        return f"<methods: {', '.join(self)}>"

    def __getitem__(self, slug: str) -> type[Any]:
        if not isinstance(slug, str):
            raise wrong_value("method", slug, "a name")
        if slug in _HOMES:
            return _class_at(_HOMES[slug])
        if slug in self._outside:
            theirs: type[Any] = self._outside[slug].load()
            return theirs
        if slug == AUTO:
            raise InvalidInputError(
                "'auto' is not a method, it chooses one: synthesize(..., method='auto')"
            )
        raise InvalidInputError(f"unknown method '{slug}'{did_you_mean(slug, [AUTO, *self])}")

    def get(self, slug: str, default: Any = None) -> Any:
        """Return the method of that slug, or the default; a mapping's own `get` wants KeyError."""
        return self[slug] if slug in self else default  # noqa: SIM401

    def __contains__(self, slug: object) -> bool:
        return isinstance(slug, str) and (slug in _HOMES or slug in self._outside)

    def __iter__(self) -> Iterator[str]:
        yield from _HOMES
        yield from self._outside

    def __len__(self) -> int:
        return len(_HOMES) + len(self._outside)


#: Every method by its slug.
METHODS = Registry()


def _class_at(home: str) -> type[Any]:
    module, _, name = home.partition(":")
    found: type[Any] = getattr(import_module(f"weftex.{module}"), name)
    return found


def method_class(slug: str) -> type[Any]:
    """Return the class of a slug, also of "auto", which loads the analyses."""
    return _class_at("tasks.auto:Auto") if slug == AUTO else METHODS[slug]


def supporting(kind: str) -> list[str]:
    """Return slugs of the methods that support a kind of canvas."""
    return [slug for slug in METHODS if kind in METHODS[slug].supports]


def owners(parameter: str) -> list[str]:
    """Return slugs of the methods that have a parameter of this name."""
    return [slug for slug in METHODS if parameter in (f.name for f in fields(METHODS[slug]))]
