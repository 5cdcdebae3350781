"""What every store of a picture does."""

from __future__ import annotations

import os
from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Any, ClassVar

from weftex.errors import FileError
from weftex.io.formats import show
from weftex.stores.layout import children, halved

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from weftex.stores.layout import Layout, Place, Window


class Store(ABC):
    """A picture on disk, of which blocks are written in any order, each by one writer.

    Parameters
    ----------
    path : str
    layout : Layout

    Raises
    ------
    InvalidInputError
        If the format cannot hold such pixels.
    """

    #: The last level is at most so many pixels high and wide.
    smallest: ClassVar[int] = 512

    def __init__(self, path: str, layout: Layout) -> None:
        self.path, self.layout = path, layout
        self.levels = layout.levels(self.smallest)
        self.check()

    def check(self) -> None:  # noqa: B027
        """Raise unless the format holds such pixels."""

    @abstractmethod
    def create(self, about: Mapping[str, Any]) -> None:
        """Make it, without pixels; `about` says what made them, in plain values."""

    @abstractmethod
    def put(self, place: Place, pixels: NDArray[Any]) -> None:
        """Write a block; when this returns it is on the disk."""

    @abstractmethod
    def read(self, level: int, window: Window) -> NDArray[Any]:
        """Return the pixels of a window."""

    @abstractmethod
    def remove(self) -> None:
        """Remove everything that `create` and `put` wrote."""

    def exists(self) -> bool:
        """Whether `create` made it."""
        return os.path.exists(self.path)

    @property
    def most_bytes(self) -> int:
        """That it may take on the disk."""
        sizes = [self.layout.shape(level) for level in range(self.levels)]
        return sum(height * width for height, width in sizes) * self.layout.bytes

    def write(self, place: Place, pixels: NDArray[Any]) -> None:
        """`put`, with errors of ours."""
        try:
            self.put(place, pixels)
        except FileError:
            raise
        except OSError as error:
            raise FileError(
                f"{show(self.path)}: cannot write: {error.strerror or error}; blocks that are done "
                "are kept, and the same command goes on"
            ) from None

    def reduced(self, place: Place) -> NDArray[Any]:
        """Return a block of a level above 0, made from the level below."""
        window = children(self.layout, place)
        return halved(self.read(place[0] - 1, window), self.layout.mixing)


def synced(path: str) -> None:
    """Wait until a file, and its name in its folder, are on the disk."""
    for one in (path, os.path.dirname(os.path.abspath(path))):
        try:
            number = os.open(one, os.O_RDONLY)
        except PermissionError:  # Windows opens no folders
            continue
        try:
            os.fsync(number)
        finally:
            os.close(number)
