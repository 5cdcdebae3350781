"""Steps of people's work, and the work of other tabs: listed, continued and removed.

A work is the folder of a session: its steps, and the uploads that they need.
"""

from __future__ import annotations

import re
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from weftex.errors import InvalidInputError
from weftex.recipe import Recipe, checked_material
from weftex.studio.refusals import Refusal
from weftex.studio.sessions import KEY, Session, Store, path_of, read_steps, read_uploads
from weftex.studio.uploads import IncomingUpload

_ID = re.compile(r"[0-9a-f]{12}")
_THUMB = re.compile(r"data:image/(webp|png|jpeg);base64,[A-Za-z0-9+/=]{1,65536}")
_LONGEST_TEXT = 200
_WORKS = 60  # that are listed
FIELDS = (
    *("id", "parent", "label", "title", "recipe", "result", "thumb"),
    *("sample", "estimated", "inverted"),
)


def step_of(given: Mapping[str, Any], result: dict[str, Any] | None) -> dict[str, Any]:
    """Check a step that the page sent, of which `result` is the description of its picture."""
    checks = {"id": (_ID, True), "parent": (_ID, False), "thumb": (_THUMB, False)}
    for name, (pattern, needed) in checks.items():
        value = given.get(name)
        fits = isinstance(value, str) and pattern.fullmatch(value)
        if (value is not None or needed) and not fits:
            raise InvalidInputError(f"{name} of the step is not as the page writes it")
    return {
        **{name: given.get(name) for name in checks},
        "label": str(given.get("label") or "")[:_LONGEST_TEXT],
        "title": str(given.get("title") or "")[:_LONGEST_TEXT],
        "recipe": Recipe.from_json(given.get("recipe")).as_json(),
        # The materials that became of its result, and that its maps were estimated from.
        **{k: checked_material(given[k]) for k in ("sample", "estimated") if given.get(k)},
        "inverted": bool(given.get("inverted")),
        "result": result,
        "time": round(time.time()),
    }


def works_of(store: Store, own: Session) -> dict[str, Any]:
    """Return the other works, the latest first, and what all of them take on the disk."""
    found = []
    for folder in store.sessions():
        if folder.name == own.key or not (steps := read_steps(folder)):
            continue
        last, size = steps[-1], sum(one.stat().st_size for one in folder.iterdir())
        about = {name: last.get(name) for name in ("title", "label", "thumb", "time")}
        found.append({"id": folder.name, "steps": len(steps), "bytes": size, **about})
    found.sort(key=lambda one: one["time"] or 0, reverse=True)
    return {"works": found[:_WORKS], "bytes": store.bytes, "most": store.limits.stored_bytes}


def _folder_of(name: str, store: Store) -> Path:
    folder = store.folder / name
    if not KEY.fullmatch(name) or not folder.is_dir():
        raise Refusal(404, "this work is no longer there")
    return folder


def continue_work(name: str, store: Store, session: Session, in_use: bool) -> list[dict[str, Any]]:
    """Add the uploads and steps of a work to a session, and return its steps.

    The work is moved, unless another tab uses it: then it is copied.
    """
    folder = _folder_of(name, store)
    steps = read_steps(folder)
    for upload, about in read_uploads(folder).items():
        if upload not in session.uploads:
            with IncomingUpload(about["name"], session) as copy:
                copy.link(path_of(folder, about), about)
    session.add_steps(steps)
    if not in_use:
        store.remove(folder)
    return steps


def remove_work(name: str, store: Store, in_use: bool) -> None:
    """Remove a work from the disk, or raise `Refusal` if a tab uses it."""
    folder = _folder_of(name, store)
    if in_use:
        raise Refusal(409, "this work is open in another tab; close that first")
    store.remove(folder)
