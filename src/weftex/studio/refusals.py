"""Errors as the page gets them: one line, an HTTP status and the field at fault."""

from __future__ import annotations

import errno
import re
from dataclasses import fields

import weftex
from weftex.errors import WeftexError
from weftex.recipe import ATLAS, FIELDS

#: Fields of requests beside recipes, and of `auto`.
_OWN = {"height", "width", "effort", "recipe", "each"}
_OWN |= {"format", "preset", "pad", "crop", *ATLAS}
#: What the library calls what a recipe calls otherwise.
_ALIASES = {"degree": "even_light"}


class Refusal(WeftexError):
    """A request that is not answered as asked."""

    def __init__(self, status: int, message: str, parameter: str | None = None) -> None:
        super().__init__(message)
        self.status, self.parameter = status, parameter


def answer_of(error: Exception) -> tuple[int, dict[str, str | None]]:
    """Return the status and the JSON of an error."""
    if isinstance(error, MemoryError):
        error = Refusal(413, "not enough memory; make the image smaller")
    elif isinstance(error, RecursionError):
        error = Refusal(400, "the request is nested too deeply")
    elif _disk_is_full(error):
        error = Refusal(507, "the disk is full; free some space, and try again")
    elif not isinstance(error, WeftexError):
        error = Refusal(500, f"internal error of the studio: {type(error).__name__}")
    line = " ".join(str(error).split())
    status, parameter = getattr(error, "status", 422), getattr(error, "parameter", None)
    return status, {"error": line, "parameter": parameter or parameter_of(line)}


def _disk_is_full(error: BaseException | None) -> bool:
    """Return whether an error, or one that it was raised from or after, says so."""
    while error is not None:
        if isinstance(error, OSError) and error.errno in (errno.ENOSPC, errno.EDQUOT):
            return True
        error = error.__cause__ or error.__context__
    return False


def parameter_of(line: str) -> str | None:
    """Return the field of a recipe, or of a method, that a message names first."""
    words = [_ALIASES.get(word, word) for word in re.findall(r"[a-z]\w+", line)[:4]]
    of_methods = {one.name for slug in weftex.METHODS for one in fields(weftex.METHODS[slug])}
    known = FIELDS | of_methods | _OWN
    return next((word for word in words if word in known), None)
