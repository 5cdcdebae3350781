"""Plain values and arrays in one compressed file."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.errors import FileError
from weftex.io.formats import show
from weftex.io.npz import opened
from weftex.io.pictures import MAX_PIXELS, atomic

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

_FORMAT = "weftex plane 1"
_MOST_BYTES = 64 * MAX_PIXELS


def write_archive(path: str, header: dict[str, Any], arrays: Mapping[str, NDArray[Any]]) -> None:
    """Write the file; it appears whole or not at all."""
    about = np.array(json.dumps({"format": _FORMAT, **header}))
    with atomic(path) as temporary, open(temporary, "wb") as file:
        np.savez_compressed(file, about=about, **arrays)  # type: ignore[arg-type]


def read_archive(path: str) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """Return what was written.

    Raises
    ------
    FileError
        If the file is missing, or something else.
    """
    try:
        with opened(path) as file:
            if file.facts["format"] != _FORMAT or file.size > _MOST_BYTES:
                raise ValueError
            return file.facts, file.read()
    except FileNotFoundError:
        raise FileError(f"{show(path)} does not exist") from None
    except Exception:  # numpy and zipfile raise many kinds, with advice that does not fit here
        raise FileError(f"{show(path)} is not a saved plane of weftex") from None


def is_archive(path: str) -> bool:
    """Whether a file is what `write_archive` wrote."""
    try:
        read_archive(path)
    except FileError:
        return False
    return True
