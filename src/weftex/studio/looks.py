"""What a material is like, for the page: scale, lattices, what `auto` would do."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import weftex
from weftex.analysis.drawn import LatticeRating, draw
from weftex.errors import InvalidInputError
from weftex.studio.materials import id_of
from weftex.studio.refusals import Refusal

if TYPE_CHECKING:
    from collections.abc import Mapping

    from weftex import Exemplar
    from weftex.analysis.drawn import Lattice, Rated
    from weftex.choice import Choice
    from weftex.recipe.making import Loaded
    from weftex.studio.sessions import Session

_LARGEST = 2**21  # pixels of a sample that is analyzed as a whole; a drag must be quick
_RUNNERS_UP = 4
_DEGREE = 2  # of the light that the button takes off


def look(loaded: Loaded, session: Session) -> dict[str, Any]:
    """Return what a material is like; larger ones are analyzed by a smaller copy."""

    def find() -> tuple[dict[str, Any], int]:
        return _look(loaded), 2**14

    found: dict[str, Any] = session.find(find, "look", id_of(loaded.spec))
    return found


def _look(loaded: Loaded) -> dict[str, Any]:
    exemplar = loaded.exemplar
    if exemplar.shape[0] * exemplar.shape[1] > _LARGEST:
        return _quick_look(loaded)
    found = weftex.analyze(exemplar, runners_up=_RUNNERS_UP)
    return {
        "scale": found.scale,
        "confidence": found.confidence,
        "scale_source": found.scale_source,
        "spectrum": [vars(band) for band in found.spectrum],
        "regularity": found.regularity,
        "lattice": _own(exemplar, found.lattice, found.ratings.found),
        "runners_up": [
            vars(draw(exemplar, one.vectors, one.goodness)) for one in found.ratings.runners_up
        ],
        "colors": found.colors,
        "tiles": list(found.tiles),
        "auto": _choice(found.choice),
        "mending": _mending(loaded.spec, found.choice, found.lattice),
        "text": str(found),
    }


def _quick_look(loaded: Loaded) -> dict[str, Any]:
    """The same of a large sample, by what `auto` looks at: a smaller copy and a part."""
    exemplar = loaded.exemplar
    model = weftex.Auto().fit_exemplar(exemplar)
    seen = model.findings
    choice = model.choose((2 * exemplar.shape[0], 2 * exemplar.shape[1]))
    return {
        "scale": seen.scale,
        "confidence": None,
        "scale_source": "smaller copy",
        "spectrum": [],
        "regularity": None,
        "lattice": _own(exemplar, seen.lattice, None),
        "runners_up": [],
        "colors": seen.colors,
        "tiles": None,
        "auto": _choice(choice),
        "mending": _mending(loaded.spec, choice, seen.lattice),
        "text": f"{exemplar.shape[1]}x{exemplar.shape[0]}, analyzed on a smaller copy\n{choice}",
    }


def rate(loaded: Loaded, vectors: str, session: Session) -> dict[str, Any]:
    """Return how good a lattice is that somebody drew, or raise `InvalidInputError`."""
    if not vectors:
        raise InvalidInputError("lattice is missing; give x1,y1,x2,y2")
    exemplar = loaded.exemplar
    if exemplar.shape[0] * exemplar.shape[1] > _LARGEST:
        raise Refusal(413, "lattice: this sample is too large to rate lattices while you wait")

    def see() -> tuple[LatticeRating, int]:
        return LatticeRating(exemplar), 64 * exemplar.shape[0] * exemplar.shape[1]

    rating: LatticeRating = session.find(see, "rating", id_of(loaded.spec))
    return vars(rating.rate(vectors))


def _own(exemplar: Exemplar, lattice: Lattice | None, rated: Rated | None) -> Any:
    """The sample's own lattice, the only one with a confidence; None if there is none."""
    if lattice is None:
        return None
    drawn = draw(exemplar, lattice.vectors, None if rated is None else rated.goodness)
    return {**vars(drawn), "confidence": lattice.confidence}


def _choice(choice: Choice) -> dict[str, Any]:
    return {"reason": choice.reason, "warnings": list(choice.warnings)}


def _mending(
    spec: Mapping[str, Any], choice: Choice, lattice: Lattice | None
) -> list[dict[str, Any]]:
    """What would help, each with what is to be added to the material's description."""
    found = []
    for line in choice.warnings:
        if "--even-light" in line and "even_light" not in spec:
            found.append({"what": "even_light", "why": line, "spec": {"even_light": _DEGREE}})
        if "--straighten" in line and "straighten" not in spec and lattice is not None:
            found.append({"what": "straighten", "why": line, "spec": {"straighten": ""}})
    askew = lattice is not None and "straighten" not in spec and _askew(lattice)
    if askew and not any(one["what"] == "straighten" for one in found):
        line = "the lattice or the rows are tilted; straighten the photo"
        found.append({"what": "straighten", "why": line, "spec": {"straighten": ""}})
    return found


def _askew(lattice: Lattice) -> bool:
    """Whether rows, or a side of the tiles, are off the picture's axes by half a degree or more."""
    turns = [abs(math.degrees(math.atan2(y, x))) % 90 for x, y in lattice.vectors]
    off = min(min(turn, 90 - turn) for turn in turns)
    return 0.5 <= off <= 15
