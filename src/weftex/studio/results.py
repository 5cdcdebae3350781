"""Results as the page sees them: facts, pictures, figures, where pixels come from."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

import weftex
from weftex import Exemplar, Synthesis
from weftex.exemplar.material import Material
from weftex.io.pictures import Picture
from weftex.quality import FIGURES, borders_of, borders_of_each, draw_borders, fault_maps
from weftex.recipe import Recipe
from weftex.recipe.command_line import command_of
from weftex.recipe.script import python_of
from weftex.results.drawing import DRAWINGS
from weftex.studio.materials import id_of, map_of, pictures_as_json
from weftex.studio.pictures import Bytes, on_screen
from weftex.studio.refusals import Refusal
from weftex.studio.sessions import Session
from weftex.studio.uploads import stem_of

#: What `Result.stem` adds; a result of a result has it once.
_ENDS = re.compile(r"(_(filled|fused|tileable|\d+x\d+))+$")


@dataclass(frozen=True)
class Result:
    """A result, and how its pictures are stored."""

    recipe: Recipe  # with its size
    result: Synthesis
    name: str  # of the first material
    folder: bool  # whether it is a set of maps
    # By the maps' names: what the files of the material are like, of which only the pixels differ.
    pictures: dict[str, Picture]
    seconds: float

    @property
    def id(self) -> str:
        """The name of a result: the same for the same recipe."""
        return id_of(self.recipe.as_json())

    @property
    def main(self) -> str:
        """The name of the picture itself among its maps."""
        return next(iter(self.pictures))

    def map(self, name: str | None) -> Exemplar:
        """Return the sample's map of this name, the picture itself by default."""
        return map_of(self.result.sample, self.main, name)

    def pixels(self, name: str | None) -> Any:
        """Return the pixels of a map."""
        own = self.map(name)
        return self.result.image if own is self.result.sample else self.result.render(own)

    @property
    def material(self) -> Material:
        """Its pictures, as a material."""
        names = self.pictures.items()
        pictures = {name: replace(like, pixels=self.pixels(name)) for name, like in names}
        roles = {name: self.map(name).role for name in pictures}
        return Material(self.name, pictures, roles, folder=self.folder)

    @property
    def tileable(self) -> bool:
        """Whether it is tileable along both axes."""
        options = self.recipe.options
        return options.get("tileable") is True or options.get("axes") is True

    @property
    def output(self) -> str:
        """What commands write: a folder for a set."""
        floats = self.pictures[self.main].pixels.dtype.kind == "f"
        return "out/" if self.folder else "out.exr" if floats else "out.png"

    @property
    def stem(self) -> str:
        """The name of exported files without their suffix; never that of the sample itself."""
        recipe, (height, width) = self.recipe, self.result.shape
        tileable = recipe.options.get("tileable") or recipe.task == "tile"
        what = {"fill": "filled", "fuse": "fused"}.get(recipe.task, f"{width}x{height}")
        stem = _ENDS.sub("", stem_of(self.name))
        return f"{stem}_{'tileable' if tileable and recipe.task != 'fill' else what}"


def described(made: Result, session: Session) -> dict[str, Any]:
    """Return a result as JSON for the page."""
    result, used = made.result, made.result.provenance
    names = {id_: session.upload(id_)["name"] for id_ in made.recipe.pictures}
    return {
        "id": made.id,
        "recipe": made.recipe.as_json(),
        **pictures_as_json(result.sample, made.pictures, made.main),
        "width": result.shape[1],
        "height": result.shape[0],
        "seconds": round(made.seconds, 3),
        "method": used.get("method", made.recipe.method.slug),
        "parameters": _parameters(used),
        "reason": used.get("reason"),
        "warnings": list(used.get("warnings", ())),
        "file": made.stem,
        "command": command_of(made.recipe, made.output, names),
        "python": python_of(made.recipe, made.output, names),
    }


def _parameters(used: Mapping[str, Any]) -> dict[str, Any]:
    """Return the parameters of a result that are not the defaults of its method."""
    declared = fields(weftex.METHODS[used["method"]]) if "method" in used else ()
    return {k.name: used[k.name] for k in declared if used.get(k.name, k.default) != k.default}


def picture_of(made: Result, map_name: str | None, drawing: str | None, session: Session) -> Bytes:
    """Return a map of a result, or a drawing of it, as a screen shows it."""
    like = made.map(map_name)
    if drawing is not None and drawing not in DRAWINGS:
        raise Refusal(404, f"there is no such drawing; known: {', '.join(DRAWINGS)}", "draw")

    def draw() -> Bytes:
        if drawing is None:
            return on_screen(like, made.pixels(map_name))
        return np.atleast_3d(made.result.draw(drawing))

    return session.find(draw, lambda found: found.nbytes, "picture", made.id, map_name, drawing)


def figures_of(made: Result, session: Session) -> dict[str, Any]:
    """Return the quality of a result as JSON for the page."""

    def measure() -> dict[str, Any]:
        found = weftex.assess(made.result.sample, made.result)
        figures = {name: getattr(found, name) for name in FIGURES}
        about = {"score": found.score, "flags": list(found.flags), "verdict": found.verdict()}
        return {**about, "figures": figures}

    return session.find(measure, lambda _: 4096, "figures", made.id)


def borders_of_maps(material: Material) -> dict[str, Any]:
    """Return how each map wraps around, downwards and to the right, as JSON for the page."""
    found = borders_of_each(material.maps)
    maps = {
        name: [{"steps": one.steps, "seam": one.seam, "good": one.badness <= 1} for one in both]
        for name, both in found.items()
    }
    return {"maps": maps, "most": found[material.main][0].most}


def drawn_borders(material: Material, name: str) -> Bytes:
    """Return a map shifted by half, with its offending borders marked."""
    if name not in material.maps:
        raise Refusal(404, "there is no such map", "map")
    return draw_borders(material.maps[name], borders_of(material.maps[name]))


def broken_of(made: Result, session: Session) -> Bytes:
    """Return a picture of where a result has broken features, as its report has it."""

    def draw() -> Bytes:
        found = fault_maps(made.result.sample, made.result.image, None).get("broken")
        if found is None:
            raise Refusal(422, "the result is too small for a picture of broken features")
        return found

    return session.find(draw, lambda found: found.nbytes, "broken", made.id)
