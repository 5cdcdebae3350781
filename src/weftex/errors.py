"""The errors that weftex raises on purpose.

Every message is one line that names the parameter, its value and the range, and where possible the
fix; the command line prints that line and exits with code 2.
"""

from __future__ import annotations

import math
import numbers
from collections.abc import Iterable
from typing import TypeGuard

__all__ = [
    "CancelledError",
    "FileError",
    "InvalidInputError",
    "UnsupportedError",
    "WeftexError",
    "did_you_mean",
    "is_number",
    "is_whole",
    "missing_packages",
    "shown",
    "whole_pair",
    "wrong_value",
]

_LONGEST = 80  # characters of a value in a message


class WeftexError(Exception):
    r"""Base class of everything that weftex raises on purpose.

    The message is one line of printable text.

    Examples
    --------
    >>> print(WeftexError("there is no " + chr(10)))
    there is no \n
    """

    def __init__(self, *about: object) -> None:
        super().__init__(*(printable(one) if isinstance(one, str) else one for one in about))


class InvalidInputError(WeftexError, ValueError):
    """An argument, an image, or a combination of arguments is invalid."""


class UnsupportedError(WeftexError):
    """The method cannot do the task, or an optional package is missing."""


class FileError(WeftexError, OSError):
    """A file cannot be read or written."""


class CancelledError(WeftexError):
    """The progress callback returned False."""


def missing_packages(what: str, extra: str) -> UnsupportedError:
    """Return the error that says what needs the packages of an extra, and how to install them."""
    from importlib.metadata import requires

    found = [one.split(";")[0] for one in requires("weftex") or () if f'"{extra}"' in one]
    return UnsupportedError(f"{what}; install it with: pip install {' '.join(map(repr, found))}")


def printable(text: str) -> str:
    """Return a text with escapes for characters that would not print, or end the line."""
    return "".join(c if c.isprintable() else ascii(c)[1:-1] for c in text)


def shown(value: object) -> str:
    """Return a value as it is written in Python, on one line and not too long.

    Examples
    --------
    >>> shown([1, 2]), len(shown(10**400))
    ('[1, 2]', 80)
    """
    try:
        text = " ".join(repr(value).split())
    except Exception:  # anybody's own, or an integer of more digits than Python prints
        text = f"a {type(value).__name__}"
    return text if len(text) <= _LONGEST else text[: _LONGEST - 3] + "..."


def size_words(shape: tuple[int, ...]) -> str:
    """Return a shape (H, W, ...) as text, such as 640x480."""
    return f"{shape[1]}x{shape[0]}"


def wrong_value(name: str, value: object, wanted: str) -> InvalidInputError:
    """Return the error that a value is not what it must be; `wanted` says that in words."""
    return InvalidInputError(f"{name} is {shown(value)}; it must be {wanted}")


def is_whole(value: object, least: int, most: float = math.inf) -> TypeGuard[int]:
    """Return whether a value is an integer, also of NumPy, within bounds; True is none."""
    whole = isinstance(value, numbers.Integral) and not isinstance(value, bool)
    return whole and least <= value <= most  # type: ignore[operator]


def is_number(value: object) -> TypeGuard[float]:
    """Return whether a value is a real number, also of NumPy; True is none."""
    return isinstance(value, numbers.Real) and not isinstance(value, bool)


def whole_pair(value: object, least: int, most: float = math.inf) -> tuple[int, int] | None:
    """Return a pair of integers within bounds, or one as both; None for any other value."""
    sides = value if isinstance(value, (tuple, list)) else (value, value)
    if len(sides) != 2 or not all(is_whole(side, least, most) for side in sides):
        return None
    return int(sides[0]), int(sides[1])


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """Return ``"; did you mean 'x'?"`` for the nearest known name, or the list of known names."""
    import difflib  # only on the way to an error

    known = sorted(known)
    near = difflib.get_close_matches(name, known, n=1)
    return f"; did you mean '{near[0]}'?" if near else f"; known: {', '.join(known)}"
