"""Results as the page sees them: facts, pictures, figures, where pixels come from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from typing import Any

import numpy as np

import weftex
from weftex import Exemplar
from weftex.exemplar.material import Material
from weftex.quality import FIGURES, borders_of, borders_of_each, draw_borders, fault_maps
from weftex.recipe.command_line import command_of
from weftex.recipe.script import python_of
from weftex.results.drawing import DRAWINGS
from weftex.studio.materials import maps_of
from weftex.studio.pictures import formats_of, shown
from weftex.studio.refusals import Refusal
from weftex.studio.sessions import Session
from weftex.studio.synthesis import Result

Bytes = np.ndarray[Any, np.dtype[np.uint8]]


def result_of(name: str, session: Session) -> Result:
    """Return a result of a session, or raise `Refusal`."""
    made: Result | None = session.recall("result", name)
    if made is None:
        raise Refusal(410, "this result is no longer in memory; make it again by its recipe")
    return made


def described(made: Result, session: Session) -> dict[str, Any]:
    """Return a result as JSON for the page."""
    result, used = made.result, made.result.provenance
    names = {id_: session.upload(id_)["name"] for id_ in made.recipe.pictures}
    return {
        "id": made.id,
        "recipe": made.recipe.as_json(),
        "width": result.shape[1],
        "height": result.shape[0],
        "main": made.main,
        "maps": maps_of(result.sample, made.main),
        "seconds": round(made.seconds, 3),
        "method": used.get("method", made.recipe.method.slug),
        "parameters": _parameters(used),
        "reason": used.get("reason"),
        "warnings": list(used.get("warnings", ())),
        "formats": {name: formats_of(picture) for name, picture in made.pictures.items()},
        "file": made.stem,
        "density": made.pictures[made.main].density,
        "command": command_of(made.recipe, made.output, names),
        "python": python_of(made.recipe, made.output, names),
    }


def _parameters(used: Mapping[str, Any]) -> dict[str, Any]:
    """Return the parameters of a result that are not the defaults of its method."""
    declared = fields(weftex.METHODS[used["method"]]) if "method" in used else ()
    names = {one.name: one.default for one in declared if one.name in used}
    return {name: used[name] for name, usual in names.items() if used[name] != usual}


def picture_of(made: Result, map_name: str | None, drawing: str | None, session: Session) -> Bytes:
    """Return a map of a result, or a drawing of it, as a screen shows it."""
    like = made.map(map_name)
    if drawing is not None and drawing not in DRAWINGS:
        raise Refusal(404, f"there is no such drawing; known: {', '.join(DRAWINGS)}", "draw")

    def draw() -> Bytes:
        if drawing is None:
            return shown(like, made.pixels(map_name))
        return np.atleast_3d(made.result.draw(drawing))

    return session.find(draw, lambda found: found.nbytes, "picture", made.id, map_name, drawing)


def figures_of(made: Result, session: Session) -> dict[str, Any]:
    """Return the quality of a result as JSON for the page."""

    def measure() -> dict[str, Any]:
        found = weftex.assess(made.result.sample, made.result)
        plain = found.as_dict()
        figures = {name: plain.get(name) for name in FIGURES}
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
    """Return a picture of where a result has broken things, as its report has it."""

    def draw() -> Bytes:
        found = fault_maps(made.result.sample, made.result.image, None).get("broken")
        if found is None:
            raise Refusal(422, "the result is too small for a map of broken things")
        return found

    return session.find(draw, lambda found: found.nbytes, "broken", made.id)


def preview_of(sample: Exemplar) -> Any:
    """Return what makes a preview's pixels fit for a screen: those of a sample's kind."""

    def show(pixels: Any) -> Any:
        same = pixels.dtype == sample.pixels.dtype and pixels.shape[2:] == sample.pixels.shape[2:]
        if not same:  # of all maps at once: features in bytes
            planes = pixels.reshape(*pixels.shape[:2], -1)
            levels = planes if planes.dtype == np.uint8 else np.zeros(planes.shape, np.uint8)
            return levels[..., :3] if levels.shape[2] >= 3 else levels[..., :1]
        return shown(sample, pixels)

    return show
