"""What a material is like, for the page: scale, lattices, light, slant, what `auto` would do."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import weftex
from weftex.analysis.canvas_lattice import four_numbers
from weftex.analysis.lattice import Lattice
from weftex.analysis.overlay import courses, lattice_lines
from weftex.analysis.relief import smaller_copy
from weftex.errors import InvalidInputError
from weftex.studio.refusals import Refusal
from weftex.tasks.auto import AutoModel

if TYPE_CHECKING:
    from weftex import Exemplar
    from weftex.analysis.autocorrelations import Autocorrelations
    from weftex.analysis.lattice import Rated
    from weftex.choice import Choice
    from weftex.studio.materials import Loaded
    from weftex.studio.sessions import Session

_LARGEST = 2**21  # pixels of a sample that is analyzed as a whole; a drag must be quick
_RUNNERS_UP = 4
_DEGREE = 2  # of the light that the button takes off


def look(loaded: Loaded, session: Session) -> dict[str, Any]:
    """Return what a material is like; larger ones are analyzed by a smaller copy."""

    def find() -> tuple[dict[str, Any], int]:
        return _look(loaded), 2**14

    found: dict[str, Any] = session.find(find, "look", loaded.id)
    return found


def _look(loaded: Loaded) -> dict[str, Any]:
    exemplar = loaded.exemplar
    if exemplar.shape[0] * exemplar.shape[1] > _LARGEST:
        return _quick_look(exemplar)
    found = weftex.analyze(exemplar, runners_up=_RUNNERS_UP)
    rated = found.ratings
    own = found.lattice
    return {
        "scale": found.scale,
        "confidence": found.confidence,
        "scale_source": found.scale_source,
        "spectrum": [vars(band) for band in found.spectrum],
        "regularity": found.regularity,
        "lattice": None if own is None else _found(exemplar, own, rated.found),
        "runners_up": [_lattice(exemplar, Lattice(one.vectors), one) for one in rated.runners_up],
        "colors": found.colors,
        "tiles": list(found.tiles),
        "auto": _choice(found.choice),
        "mending": _mending(loaded.spec, found.choice, own),
        "text": str(found),
    }


def _quick_look(exemplar: Exemplar) -> dict[str, Any]:
    """The same of a large sample, by what `auto` looks at: a smaller copy and a part."""
    model = AutoModel(weftex.Auto(), exemplar)
    seen = model.findings
    choice = model.choose((2 * exemplar.shape[0], 2 * exemplar.shape[1]))
    return {
        "scale": seen.scale,
        "confidence": None,
        "scale_source": "smaller copy",
        "spectrum": [],
        "regularity": None,
        "lattice": None if seen.lattice is None else _found(exemplar, seen.lattice, None),
        "runners_up": [],
        "colors": seen.colors,
        "tiles": None,
        "auto": _choice(choice),
        "mending": _mending({}, choice, seen.lattice),
        "text": f"{exemplar.shape[1]}x{exemplar.shape[0]}, looked at by a smaller copy\n{choice}",
    }


def rate(loaded: Loaded, vectors: str, session: Session) -> dict[str, Any]:
    """Return how good a lattice is that somebody drew, or raise `InvalidInputError`."""
    from weftex.analysis.autocorrelations import ALPHA, SIGNIFICANT, autocorrelations
    from weftex.analysis.lattice import rate_lattices
    from weftex.tasks.analyze import given_lattice

    if not vectors:
        raise InvalidInputError("lattice is missing; give x1,y1,x2,y2")
    exemplar = loaded.exemplar
    if exemplar.shape[0] * exemplar.shape[1] > _LARGEST:
        raise Refusal(413, "lattice: this sample is too large to be rated while a hand waits")
    given = given_lattice(vectors, exemplar)
    rule: dict[str, Any] = {"goodness": "contrast", "alpha": ALPHA, "significant": SIGNIFICANT}

    def see() -> tuple[Autocorrelations, int]:
        size = 64 * exemplar.shape[0] * exemplar.shape[1]
        return autocorrelations(exemplar, ALPHA, SIGNIFICANT), size

    seen = session.find(see, "views", loaded.id)
    rated = rate_lattices(exemplar, given, **rule, runners_up=0, fields=seen)[0]
    return _lattice(exemplar, given, rated)


def _choice(choice: Choice) -> dict[str, Any]:
    return {"reason": choice.reason, "warnings": list(choice.warnings)}


def _found(exemplar: Exemplar, lattice: Lattice, rated: Rated | None) -> dict[str, Any]:
    """The sample's own lattice, of which alone a confidence is known."""
    return _lattice(exemplar, lattice, rated) | {"confidence": lattice.confidence}


def _lattice(exemplar: Exemplar, lattice: Lattice, rated: Rated | None) -> dict[str, Any]:
    """A lattice, with the lines that show it."""
    small, step = smaller_copy(exemplar, 1024)
    scaled = Lattice(tuple((x / step, y / step) for x, y in lattice.vectors))
    lines = lattice_lines(small, scaled)
    return {
        "vectors": [list(map(float, vector)) for vector in lattice.vectors],
        "numbers": ",".join(f"{number:g}" for number in four_numbers(lattice)),
        "words": courses(lattice),
        "confidence": None,
        "goodness": None if rated is None else rated.goodness,
        "lines": [
            {"across": [float(part) / step for part in across], "phase": phase}
            for across, phase in lines
        ],
    }


def _mending(spec: dict[str, Any], choice: Choice, lattice: Lattice | None) -> list[dict[str, Any]]:
    """What would help, each with what is to be added to the material's description."""
    found = []
    for line in choice.warnings:
        if "--even-light" in line and "even_light" not in spec:
            found.append({"what": "even_light", "why": line, "spec": {"even_light": _DEGREE}})
        if "--straighten" in line and "straighten" not in spec and lattice is not None:
            found.append({"what": "straighten", "why": line, "spec": {"straighten": ""}})
    askew = lattice is not None and "straighten" not in spec and _askew(lattice)
    if askew and not any(one["what"] == "straighten" for one in found):
        line = "the lattice or the rows stand askew; straighten the photo"
        found.append({"what": "straighten", "why": line, "spec": {"straighten": ""}})
    return found


def _askew(lattice: Lattice) -> bool:
    """Whether rows, or a side of the tiles, are off the picture's axes by half a degree or more."""
    import math

    turns = [abs(math.degrees(math.atan2(y, x))) % 90 for x, y in lattice.vectors]
    off = min(min(turn, 90 - turn) for turn in turns)
    return 0.5 <= off <= 15
