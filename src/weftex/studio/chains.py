"""Workflows: chains of steps with a name, which the page replays on other photos.

A step is a recipe, or an estimate of maps. Its materials are pictures called "photo" or "step 2",
the result of an earlier step; any other picture belongs to the photo that the chain was made with.
"""

from __future__ import annotations

import json
import re
import threading
from pathlib import Path
from typing import Any

from weftex.errors import FileError, InvalidInputError, shown, wrong_value
from weftex.io.pictures import write_text
from weftex.recipe import Recipe, checked_material
from weftex.studio.refusals import Refusal

Chain = list[dict[str, Any]]

_FILE = "presets.json"
_MOST, _MOST_STEPS, _LONGEST = 200, 32, 60
_SOURCE = re.compile(r"photo|step ([1-9]\d?)")


class Chains:
    """The chains in the data folder, one file for all servers that share it."""

    def __init__(self, folder: Path) -> None:
        self._path, self._lock = folder / _FILE, threading.Lock()

    def all(self) -> dict[str, Chain]:
        """Return the chains by their names."""
        try:
            found = json.loads(self._path.read_text("utf-8"))
            return {str(name): list(steps) for name, steps in found.items()}
        except FileNotFoundError:
            return {}
        except (OSError, ValueError, TypeError, AttributeError) as error:
            raise FileError(f"{self._path}: cannot be read ({error}); move it away") from None

    def change(self, name: Any, *, to: Any = None, steps: Any = None) -> dict[str, Chain]:
        """Add a chain, rename it with `to`, or remove it without either; return all chains."""
        with self._lock:
            chains = self.all()
            if steps is None and name not in chains:
                raise Refusal(404, "there is no such workflow; another page removed it", "name")
            new = _checked_name(name if to is None else to)
            if new in chains and (steps is not None or to not in (None, name)):
                raise Refusal(409, f"the workflow {shown(new)} exists; choose another name", "name")
            if steps is not None:
                if len(chains) >= _MOST:
                    raise Refusal(413, f"there are {_MOST} workflows, the limit; remove one")
                if not isinstance(steps, list) or not 0 < len(steps) <= _MOST_STEPS:
                    raise wrong_value("steps", steps, f"1 to {_MOST_STEPS} steps")
                chains[new] = [_checked_step(step, number) for number, step in enumerate(steps)]
            elif to is not None:
                chains = {new if k == name else k: chain for k, chain in chains.items()}
            else:
                del chains[name]
            write_text(self._path, json.dumps(chains))
            return chains


def _checked_name(name: Any) -> str:
    if not isinstance(name, str) or not 0 < len(name.strip()) <= _LONGEST or not name.isprintable():
        raise InvalidInputError(f"name is {shown(name)}; it must be 1 to {_LONGEST} characters")
    return name.strip()


def _checked_step(step: Any, before: int) -> dict[str, Any]:
    """Return a step that has `before` steps before it."""
    if not isinstance(step, dict) or ("recipe" in step) == ("estimate" in step):
        raise InvalidInputError(f"steps has {shown(step)}; it must have a recipe or an estimate")
    found: dict[str, Any] = {"label": str(step.get("label") or "")[:_LONGEST]}
    if "recipe" in step:
        found["recipe"] = Recipe.from_json(step["recipe"]).as_json()
        source = found["recipe"]["materials"][0]
    else:
        source = found["estimate"] = checked_material(step["estimate"])
        found["invert"] = bool(step.get("invert"))
    known = _SOURCE.fullmatch(source.get("maps", {}).get("color", ""))
    if known is None or int(known[1] or 0) > before:
        raise InvalidInputError("materials of a step must begin with the photo or an earlier step")
    return found
