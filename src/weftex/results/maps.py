"""The maps of a result."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any

from numpy.typing import NDArray


class RenderedMaps(Mapping[str, NDArray[Any]]):
    """Maps by name, each rendered on access, so that a set of large maps is never all in memory."""

    def __init__(self, names: Iterable[str], render: Callable[[str], NDArray[Any]]) -> None:
        self._names, self._render = tuple(names), render

    def __getitem__(self, name: str) -> NDArray[Any]:
        if name not in self._names:
            raise KeyError(name)
        return self._render(name)

    def __contains__(self, name: object) -> bool:
        return name in self._names  # without rendering it

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)

    def __repr__(self) -> str:
        return f"<maps: {', '.join(self._names) or 'none'}>"
