"""A cache of blocks, up to a limit of memory."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Hashable
from concurrent.futures import Future
from threading import Lock
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from numpy.typing import NDArray


class BlockCache:
    """A thread-safe cache of arrays with at most `most` bytes; the least recently used go first.

    Of two threads that want one block, one computes it and the other waits.
    """

    def __init__(self, most: int) -> None:
        self.most, self.size = most, 0
        self._lock = Lock()
        self._kept: OrderedDict[Hashable, Future[NDArray[Any]]] = OrderedDict()

    def __contains__(self, key: Hashable) -> bool:
        return key in self._kept

    def get(self, key: Hashable, make: Callable[[], NDArray[Any]]) -> NDArray[Any]:
        """Return what is kept under a key, or make it."""
        with self._lock:
            found = self._kept.get(key)
            making = self._kept.setdefault(key, Future())
            self._kept.move_to_end(key)
        if found is not None:
            return found.result()
        try:
            made = make()
        except BaseException as error:
            with self._lock:
                del self._kept[key]
            making.set_exception(error)
            raise
        made.setflags(write=False)
        making.set_result(made)
        with self._lock:
            self.size += made.nbytes
            for old in [*self._kept] if self.size > self.most else ():
                if self.size > self.most and old != key and self._kept[old].done():
                    self.size -= self._kept.pop(old).result().nbytes
        return made
