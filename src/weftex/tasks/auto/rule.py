"""The rule of `auto`: a method for a sample and a canvas."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Any

from weftex.analysis.canvas_lattice import (
    MOST_STRETCHED,
    STIFF,
    VISIBLE_STRAIN,
    Around,
    CanvasLattice,
    fitting_sizes,
    is_sure,
)
from weftex.analysis.lattice import Lattice, find_lattice
from weftex.analysis.overlay import courses
from weftex.analysis.properties import FORMS
from weftex.analysis.relief import LOOK, smaller_copy
from weftex.analysis.rows import rows_around
from weftex.canvas import Canvas
from weftex.errors import size_words
from weftex.exemplar import Exemplar
from weftex.tasks.auto.findings import SMALLEST_ANALYZED, Findings

__all__ = ["Choice"]

_ROWS = 0.6  # confidence from which blocks are placed by rows
_FINE = 1 / 12  # scale over the side: a patch, a quarter of the side, holds three features in a row
_GRAIN = 1 / 20  # scale over the side up to which cut features do not show, but repeats do
#: Sidedness up to which a material looks the same upside down, or turned and in a mirror.
_SIDED = 0.06
_LARGE = 2**24  # pixels of the output above which blocks on a lattice take a tenth of the time
_TINY = 8  # pixels a side, below which patches would have 1 to 3 pixels and take minutes
_FEW_COLORS = 32  # drawings and labels, which must not be blended
#: Pixels of a sample, a hole, or around any hole, up to which the entire sample is always placed.
_SMALL = 2**18
_AROUND = 2**22  # pixels around such a hole, up to which it is, too; more can take minutes
#: Keep features whole: place the entire sample where it fits best, and cut around obstacles.
WHOLE = {"placement": "entire"}


@dataclass(frozen=True)
class Choice:
    """A method for a sample, and why.

    Attributes
    ----------
    method : str
        A name in `weftex.METHODS`.
    parameters : dict
        Parameters that differ from the method's defaults.
    because : str
        The reason, as a clause.
    warnings : tuple of str
        Faults of the sample that no method can repair, with their size and a remedy.
    """

    method: str
    parameters: dict[str, Any] = field(default_factory=dict)
    because: str = ""
    warnings: tuple[str, ...] = ()

    @property
    def reason(self) -> str:
        """One line: the method, and why."""
        return f"{self.method}, because {self.because}"

    def as_dict(self) -> dict[str, Any]:
        """Return everything as numbers, texts, lists and dicts, ready for JSON."""
        return {
            "method": self.method,
            "parameters": self.parameters,
            "reason": self.reason,
            "warnings": list(self.warnings),
        }

    def __str__(self) -> str:
        return "; ".join((self.reason, *(f"but {text}" for text in self.warnings)))


def choose(findings: Findings, canvas: Canvas | Around, *, patient: bool = False) -> Choice:
    """Return the method for a sample and a plane, or a canvas that is empty.

    It is that of the first rule that applies. `patient`: entire samples on a lattice of any size.
    """
    large = any(canvas.wrap) if isinstance(canvas, Around) else math.prod(canvas.shape) > _LARGE
    entire = patient or not large
    choice = (
        _too_small(findings)
        or _in_rows(findings, canvas)
        or _regular(findings, canvas, entire)
        or _by_scale(findings, canvas)
    )
    return replace(choice, warnings=(*_warnings(findings), *choice.warnings))


def _too_small(findings: Findings) -> Choice | None:
    """Return graph cut where nothing can be analyzed, or what copies pixels."""
    if min(findings.shape) >= SMALLEST_ANALYZED:
        return None
    because = f"the sample is too small to analyze ({size_words(findings.shape)})"
    return Choice("graphcut" if min(findings.shape) >= _TINY else "ashikhmin", {}, because)


def _regular(findings: Findings, canvas: Canvas | Around, entire: bool) -> Choice | None:
    """Return what follows a sure lattice or rows, and what does not where they do not fit."""
    lattice, exact = findings.full or findings.lattice, findings.exact or findings.full is not None
    if lattice is None or not may_place(lattice, findings.shape):
        return None
    because = f"the sample has {words(lattice)}"
    vectors = tuple(lattice)
    strain, notes = CanvasLattice(vectors, canvas).strain, strain_notes(vectors, canvas)
    if strain > (MOST_STRETCHED if exact and entire else VISIBLE_STRAIN):
        because = f"{because}; this pattern does not fit a tileable {size_words(canvas.shape)}"
        if isinstance(canvas, Around):  # whose period may be too short for entire samples
            return Choice("quilting", {}, because, notes)
        return replace(_whole(findings, because), warnings=notes)
    given = {"lattice": vectors} if exact else {}
    if exact and entire:
        return Choice("graphcut", {**WHOLE, **given}, because, notes)
    if exact and isinstance(canvas, Canvas):
        because = f"{because}; the output is large, --effort best is slower and better"
    return Choice("near-regular", given, because, notes)


def _in_rows(findings: Findings, canvas: Canvas | Around) -> Choice | None:
    """Return entire samples by rows whose joints run through, such as boards."""
    if not findings.rows or isinstance(canvas, Around):
        return None
    return Choice("graphcut", {"placement": "rows"}, "the sample has rows of different kinds")


def _by_scale(findings: Findings, canvas: Canvas | Around) -> Choice:
    """Return graph cut for anything else, or quilting for drawings of fine structure."""
    # The scale of a smaller copy is not what `analyze` measures.
    scale, shorter, exact = findings.scale, min(findings.shape), findings.exact
    if scale > _FINE * shorter:
        told = f"the structure is irregular (features of {scale:.3g} px)"
        return _whole(findings, told if exact else "the structure is irregular")
    because = f"the features are small ({scale:.3g} px of {shorter})"
    because = because if exact else "the features are small"
    if findings.colors <= _FEW_COLORS:
        because = f"{because} and its few colors ({findings.colors}) must not be blended"
        return Choice("quilting", {}, because)
    grain = scale <= _GRAIN * shorter and isinstance(canvas, Canvas)  # blocks of a plane are large
    if grain and _orientations(findings) != "all":
        return Choice("graphcut", {}, because)
    return _whole(findings, because)


def _whole(findings: Findings, because: str) -> Choice:
    """Return graph cut with entire samples, also turned and mirrored where that looks the same."""
    way = _orientations(findings)
    if way == "upright":
        return Choice("graphcut", dict(WHOLE), because)
    words = {"half-turns": "upside down", "all": "from all sides"}[way]
    because = f"{because} and the material looks the same {words}"
    return Choice("graphcut", {**WHOLE, "orientations": way}, because)


def _orientations(findings: Findings) -> str:
    upside_down, turned = findings.sidedness
    if upside_down > _SIDED:
        return "upright"
    return "half-turns" if turned > _SIDED else "all"


def choose_for_hole(exemplar: Exemplar, canvas: Canvas) -> Choice:
    """Return graph cut for known pixels: on a lattice, of the entire sample, or of parts of it."""
    missing = 0 if canvas.hole is None else int(canvas.hole.sum())
    known = int(exemplar.usable.sum())
    if known < min(missing, 4 * _TINY**2):
        return Choice("ashikhmin", {}, f"only {known} pixels are known around the hole")
    few = missing <= _SMALL
    pixels, lattice = math.prod(exemplar.shape), None
    whole = dict(WHOLE) if pixels <= (_AROUND if few else _SMALL) else {}
    if canvas.known_from is not None:
        small, step = smaller_copy(exemplar, LOOK)
        found = find_lattice(small) if min(small.shape) >= SMALLEST_ANALYZED else None
        lattice = found if found and may_place(found, small.shape) else None
    if lattice is None or len(lattice.vectors) == 1:
        even, levels = lattice is not None, exemplar.matching()
        if rows_around(levels, exemplar.usable, canvas, even) is not None:
            because = "joints run through the photo around the hole"
            return Choice("graphcut", {"placement": "rows"}, because)
    if lattice is None:
        return Choice("graphcut", whole, "no clear lattice was found around the hole")
    found = Lattice(tuple((x * step, y * step) for x, y in lattice.vectors), lattice.confidence)
    because = f"the photo around the hole has {words(found)}"
    if pixels > _SMALL:  # the smaller copy's vectors are not exact enough
        exact = find_lattice(exemplar) if found.area or whole else None
        if exact is None or len(exact.vectors) != len(found.vectors):
            return Choice("graphcut", whole, f"{because}, and is large")
        found = exact
    vectors = tuple(found)
    if CanvasLattice(vectors, canvas).strain > STIFF:
        return Choice("graphcut", {}, f"{because}, which do not fit {size_words(canvas.shape)}")
    return Choice("graphcut", {**WHOLE, "lattice": vectors}, because)


def may_place(lattice: Lattice, shape: tuple[int, int]) -> bool:
    """Return whether blocks may be placed by a lattice, or by rows."""
    if len(lattice.vectors) == 1:
        return lattice.confidence >= _ROWS
    return is_sure(lattice, math.prod(shape))


def _warnings(findings: Findings) -> list[str]:
    """Return the faults of the sample that no method can repair."""
    even, found = findings.evenness, []
    if even.large_forms > FORMS:
        found.append(
            "the sample shows one object, or too few features (large forms have "
            f"{100 * even.large_forms:.0f} % of the contrast); show more of the material"
        )
    elif even.lit_unevenly:
        found.append(
            f"the light changes by {even.light_range:.0f} of 255 levels across the sample; "
            "correct it with --even-light, or crop a part"
        )
    return found


def words(lattice: Lattice) -> str:
    """Return a lattice or rows in words, with the confidence."""
    kind = "a lattice of {}" if len(lattice.vectors) == 2 else "rows {} apart"
    return f"{kind.format(courses(lattice))} (confidence {lattice.confidence:g})"


def strain_notes(vectors: tuple[float, ...], canvas: Canvas | Around) -> tuple[str, ...]:
    """Return by how much a canvas strains a lattice, and sizes that fit; () if little."""
    strain = CanvasLattice(vectors, canvas).strain
    if strain <= STIFF:
        return ()
    sizes = " or ".join(map(size_words, fitting_sizes(vectors, canvas)))
    better = f"{sizes} would fit better (--fit uses the nearest)"
    if not sizes:  # such as where it lies at a slant
        better = "no similar size fits; straighten the sample (--straighten)"
    size = size_words(canvas.shape)
    return (f"the lattice has to be stretched by {100 * strain:.1f} % to fit {size}; {better}",)
