"""Blocks that were made, kept as long as there is room."""

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
        self._kept: OrderedDict[Hashable, NDArray[Any]] = OrderedDict()
        self._making: dict[Hashable, Future[NDArray[Any]]] = {}

    def __contains__(self, key: Hashable) -> bool:
        return key in self._kept

    def get(self, key: Hashable, make: Callable[[], NDArray[Any]]) -> NDArray[Any]:
        """Return what is kept under a key, or make it."""
        with self._lock:
            if key in self._kept:
                self._kept.move_to_end(key)
                return self._kept[key]
            waiting = self._making.get(key)
            if waiting is None:
                making: Future[NDArray[Any]] = Future()
                self._making[key] = making
        if waiting is not None:
            return waiting.result()
        try:
            made = make()
        except BaseException as error:
            with self._lock:
                del self._making[key]
            making.set_exception(error)
            raise
        made.setflags(write=False)
        with self._lock:
            del self._making[key]
            self._kept[key] = made
            self.size += made.nbytes
            while self.size > self.most and len(self._kept) > 1:
                self.size -= self._kept.popitem(last=False)[1].nbytes
        making.set_result(made)
        return made
