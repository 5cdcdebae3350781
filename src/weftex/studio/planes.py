"""Windows of endless planes, made as they come into view."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from weftex.canvas import FAR
from weftex.endless.boxes import A_BLOCK
from weftex.studio.about import is_endless
from weftex.studio.materials import id_of, maps_of
from weftex.studio.pictures import shown, whole_number
from weftex.studio.recipes import Recipe
from weftex.studio.refusals import Refusal
from weftex.tasks.auto import AutoModel

if TYPE_CHECKING:
    from collections.abc import Mapping

    import numpy as np
    from numpy.typing import NDArray

    from weftex.method import Model
    from weftex.studio.making import Bench

    Bytes = NDArray[np.uint8]

_LARGEST = 1024  # pixels a side of a window
_ENDLESS = 2**15  # pixels a side of a picture that has the method of a plane


@dataclass(frozen=True)
class Plane:
    """A fitted method that makes windows."""

    model: Model
    main: str  # the name of its picture among the maps
    seed: int
    reason: str | None  # why `auto` took the method

    def described(self, name: str) -> dict[str, Any]:
        """Return what the page is told of it."""
        maps = maps_of(self.model.exemplar, self.main)
        method = self.model.method.slug
        return {"id": name, "maps": maps, "method": method, "reason": self.reason}


def begin(given: Any, bench: Bench) -> dict[str, Any]:
    """Fit the method of a recipe to its material; what the page is told of the plane."""
    recipe = Recipe.of(given)
    name = id_of({"plane": recipe.changed(size=None, tileable=False).as_json()})

    def fit() -> tuple[Plane, int]:
        if not is_endless(recipe.method):
            recipe.method.require_kind("random_access")
        recipe.method.require(A_BLOCK)
        loaded, model = bench.model(recipe)
        reason = model.choose(_ENDLESS).reason if isinstance(model, AutoModel) else None
        return Plane(model, loaded[0].material.main, recipe.seed, reason), 2**20

    plane: Plane = bench.memory.find((bench.session.key, "plane", name), fit)
    return plane.described(name)


def window(name: str, query: Mapping[str, str], bench: Bench) -> Bytes:
    """Return a window of a plane as a screen shows it, or raise `Refusal`."""
    plane: Plane | None = bench.memory.get((bench.session.key, "plane", name))
    if plane is None:
        raise Refusal(410, "this plane is not in memory any more; begin it again")
    far = FAR - _LARGEST
    top, left = (whole_number(query, side, 0, -far, far) for side in ("top", "left"))
    height, width = (whole_number(query, side, 256, 1, _LARGEST) for side in ("height", "width"))
    wanted = query.get("map") or plane.main
    sample = plane.model.exemplar
    if wanted != plane.main and wanted not in sample.maps:
        raise Refusal(404, "there is no such map", "map")
    key = (bench.session.key, "window", name, top, left, height, width)

    def make() -> tuple[Any, int]:
        made = plane.model.window(top, left, height, width, seed=plane.seed, threads=1)
        return made, 2 * made.image.nbytes + sum(array.nbytes for array in made.arrays().values())

    made = bench.memory.find(key, make)
    if wanted == plane.main:
        return shown(sample, made.image)
    return shown(sample.map(wanted), made.render(sample.map(wanted)))
