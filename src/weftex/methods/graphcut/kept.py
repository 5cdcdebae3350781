"""What is made of a sample once, for all pictures: blocks of a plane are many and small."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeVar
from weakref import WeakKeyDictionary

if TYPE_CHECKING:
    from collections.abc import Callable, Hashable

    from weftex.search.windows import Windows

_T = TypeVar("_T")
_KEPT: WeakKeyDictionary[Windows, dict[Hashable, Any]] = WeakKeyDictionary()


def kept(windows: Windows, key: Hashable, make: Callable[[], _T]) -> _T:
    """Return what was made of a sample's windows under a key, or make it."""
    found = _KEPT.setdefault(windows, {})
    if key not in found:
        found[key] = make()
    result: _T = found[key]
    return result
