"""Windows of endless planes, made as they come into view."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from weftex.recipe import Recipe
from weftex.studio.making import fitted, open_job
from weftex.studio.materials import id_of, map_of, maps_of
from weftex.studio.pictures import shown, whole_number
from weftex.studio.refusals import Refusal

if TYPE_CHECKING:
    from collections.abc import Mapping

    import numpy as np
    from numpy.typing import NDArray

    from weftex.method import Model
    from weftex.studio.sessions import Session

_LARGEST = 1024  # pixels a side of a window
_FAR = 2**40  # pixels from the middle of a plane


@dataclass(frozen=True)
class Plane:
    """A fitted method that makes windows."""

    model: Model
    main: str  # the name of its picture among the maps
    seed: int


def begin(given: Any, session: Session) -> dict[str, Any]:
    """Fit the method of a recipe to its material; return the plane as JSON for the page."""
    recipe = Recipe.from_json(given)
    job = open_job(recipe.changed(size=None, tileable=False), session)
    name = id_of({"plane": job.recipe.as_json()})

    def fit() -> tuple[Plane, int]:
        return Plane(fitted(job, session, job.sample), next(iter(job.pictures)), recipe.seed), 2**20

    plane: Plane = session.find(fit, "plane", name)
    return {"id": name, "maps": maps_of(plane.model.exemplar, plane.main)}


def window(name: str, query: Mapping[str, str], session: Session) -> NDArray[np.uint8]:
    """Return a window of a plane as a screen shows it, or raise `Refusal`."""
    plane: Plane | None = session.recall("plane", name)
    if plane is None:
        raise Refusal(410, "this plane is not in memory any more; begin it again")
    top, left = (whole_number(query, side, 0, -_FAR, _FAR) for side in ("top", "left"))
    height, width = (whole_number(query, side, 256, 1, _LARGEST) for side in ("height", "width"))
    like = map_of(plane.model.exemplar, plane.main, query.get("map"))

    def make() -> tuple[Any, int]:
        made = plane.model.window(top, left, height, width, seed=plane.seed, threads=1)
        return made, 2 * made.image.nbytes + sum(array.nbytes for array in made.arrays().values())

    made = session.find(make, "window", name, top, left, height, width)
    return shown(like, made.image if like is plane.model.exemplar else made.render(like))
