"""Results as the page sees them: facts, pictures, figures, where pixels come from."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

import weftex
from weftex.io.formats import FORMATS
from weftex.results.drawing import DRAWINGS
from weftex.studio.about import is_endless
from weftex.studio.pictures import shown
from weftex.studio.refusals import Refusal
from weftex.studio.words import command_of, python_of

if TYPE_CHECKING:
    from weftex import Exemplar
    from weftex.io.pictures import Picture
    from weftex.studio.making import Bench, Made

    Bytes = np.ndarray[Any, np.dtype[np.uint8]]

_ABOUT = ("method", "seed", "reason", "warnings", "best_of")


def result_of(name: str, bench: Bench) -> Made:
    """Return a result of a session, or raise `Refusal`."""
    made: Made | None = bench.memory.get((bench.session.key, "result", name))
    if made is None:
        raise Refusal(410, "this result is not in memory any more; it is made again by its recipe")
    return made


def remember(made: Made, bench: Bench) -> None:
    """Keep a result as long as there is room."""
    key = (bench.session.key, "result", made.recipe.id)
    bench.memory.put(key, made, 2 * made.bytes)


def described(made: Made, bench: Bench) -> dict[str, Any]:
    """Return what the page is told of a result."""
    result, used = made.result, made.result.provenance
    height, width = result.shape
    sample = result.sample
    maps = []
    for name, picture in made.pictures.items():
        one = made.map(name)
        times = 1 if name == made.main else sample.scale_of(name)
        maps.append({
            "name": name,
            "role": one.role.name,
            "kind": one.role.kind,
            "width": int(width * times),
            "height": int(height * times),
            "channels": one.channels,
            "dtype": picture.pixels.dtype.name,
            "alpha": one.alpha,
        })  # fmt: skip
    names = {id_: bench.session.upload(id_)["name"] for id_ in made.recipe.uploads}
    return {
        "id": made.recipe.id,
        "recipe": made.recipe.as_json(),
        "width": width,
        "height": height,
        "main": made.main,
        "maps": maps,
        "seconds": round(made.seconds, 3),
        "method": used.get("method", made.recipe.method.slug),
        "parameters": {k: v for k, v in used.items() if k not in _ABOUT},
        "reason": used.get("reason"),
        "warnings": list(used.get("warnings", ())),
        "best_of": used.get("best_of"),
        "formats": {name: formats_of(picture) for name, picture in made.pictures.items()},
        "command": command_of(made, names),
        "python": python_of(made, names),
        "plane": is_endless(made.recipe.method),
        "bytes": made.bytes,
    }


def formats_of(picture: Picture) -> list[str]:
    """Return the suffixes of the formats that hold such pixels."""
    pixels = picture.pixels
    colors = (pixels.shape[2] if pixels.ndim == 3 else 1) - picture.alpha
    dtype = "float32" if pixels.dtype.kind == "f" else pixels.dtype.name
    return [
        suffix
        for suffix, one in FORMATS.items()
        if suffix not in (".jpeg", ".tiff") and one.holds(dtype, colors, picture.alpha)
    ]


def picture_of(made: Made, map_name: str | None, drawing: str | None, bench: Bench) -> Bytes:
    """Return a map of a result, or a drawing of it, as a screen shows it."""
    name = made.main if map_name is None else map_name
    if name not in made.pictures:
        raise Refusal(404, "there is no such map", "map")
    if drawing is not None and drawing not in DRAWINGS:
        raise Refusal(404, f"there is no such drawing; known: {', '.join(DRAWINGS)}", "draw")
    key = (bench.session.key, "picture", made.recipe.id, name, drawing)

    def draw() -> tuple[Bytes, int]:
        if drawing is not None:
            found = made.result.draw(drawing)
            found = found if found.ndim == 3 else found[..., None]
        else:
            found = shown(made.map(name), made.pixels(name))
        return found, found.nbytes

    picture: Bytes = bench.memory.find(key, draw)
    return picture


def figures_of(made: Made, bench: Bench) -> dict[str, Any]:
    """Return how good a result is."""
    from weftex.quality.figures import FIGURES

    def measure() -> tuple[dict[str, Any], int]:
        found = weftex.assess(made.result.sample, made.result)
        plain = found.as_dict()
        figures = {name: plain.get(name) for name in FIGURES}
        about = {"score": found.score, "flags": list(found.flags), "verdict": found.verdict()}
        return {**about, "figures": figures}, 4096

    key = (bench.session.key, "figures", made.recipe.id)
    found: dict[str, Any] = bench.memory.find(key, measure)
    return found


def faults_of(made: Made, bench: Bench) -> dict[str, Bytes]:
    """Return maps of where a result fails, those of its report."""
    from weftex.pages.reports import fault_maps
    from weftex.quality.assess import made_from

    def look() -> tuple[dict[str, Bytes], int]:
        found = fault_maps(made.result.sample, made.result.image, made_from(made.result))
        return found, sum(one.nbytes for one in found.values())

    key = (bench.session.key, "faults", made.recipe.id)
    found: dict[str, Bytes] = bench.memory.find(key, look)
    return found


def coordinates_of(made: Made, window: tuple[int, int, int, int]) -> bytes:
    """Return rows and columns in the sample of the pixels of a window, int32, little endian."""
    found = made.result.layers(window)[0][:, :, 0]
    return np.ascontiguousarray(found, "<i4").tobytes()


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
