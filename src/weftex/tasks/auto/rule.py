"""The rule of `auto`: a method by what a sample is like and what is to be made."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from weftex.analysis.canvas_lattice import VISIBLE_STRAIN, CanvasLattice, four_numbers
from weftex.analysis.canvas_lattice import is_sure as lattice_is_sure
from weftex.analysis.courses import courses
from weftex.analysis.lattice import Lattice, find_lattice
from weftex.analysis.relief import smaller_copy
from weftex.analysis.scale import dominant_scale
from weftex.choice import Choice
from weftex.errors import InvalidInputError
from weftex.tasks.auto.findings import LOOK, SMALLEST_ANALYZED, Findings

if TYPE_CHECKING:
    from weftex.canvas import Canvas
    from weftex.exemplar import Exemplar

_ROWS = 0.6  # confidence from which blocks are laid by rows
_FINE = 1 / 12  # scale over the side: a patch, a quarter of it, holds three things in a row
_GRAIN = 1 / 20  # up to this no thing is large enough to be seen cut, but copies of it all are
#: Strain of a lattice that goes around a canvas, up to which the entire sample is laid by it as it
#: is: blocks are smaller, and stray less.
_STIFF = 0.02
#: Sidedness up to which a material looks as right upside down; what is lit from a side, drips or
#: stands has more.
_SIDED = 0.06
#: Pixels of the output above which nothing is turned, which takes three fifths more time there.
_TURNED = 2**22
_FEW_COLORS = 32  # drawings, labels: no mixtures of colors
#: Pixels of the output above which the entire sample is laid only where large things are to stay
#: whole, since other ways take a tenth of the time.
PATIENCE = 2**20
#: Pixels of a sample, or around a hole, up to which all of them are laid in any case: patches of a
#: larger one are cut in less than half of the time.
_SMALL = 2**18
#: Whole things: the sample as it is, laid where it fits best, and cut around what is in the way.
WHOLE = {"placement": "entire"}

_LIGHT, _LIGHT_RANGE = 0.25, 40.0  # samples that are lit evenly have up to 0.2 by chance
_FORMS = 0.45  # samples of many things have up to 0.33


def choose(findings: Findings, canvas: Canvas) -> Choice:
    """The rule: a method by what a sample is like and what is to be made.

    Parameters
    ----------
    findings : Findings
        See `look`.
    canvas : Canvas
        Without known pixels and without a guide.

    Examples
    --------
    >>> from weftex.analysis.evenness import Evenness
    >>> from weftex.canvas import Canvas
    >>> flat = Evenness(0.0, 0.0, 0.0, (1.0, 1.0))
    >>> grass = Findings((256, 256), None, True, 12.5, 5000, flat)
    >>> str(choose(grass, Canvas(512, 512)))
    'fine structure, 12.5 px of 256: graphcut'
    """
    shorter, lattice = min(findings.shape), findings.lattice
    warnings = _warnings(findings)
    parameters: dict[str, Any] = {}
    if shorter < SMALLEST_ANALYZED:
        slug, said = "graphcut", f"too small to be analyzed, {_size(findings.shape)}"
    elif lattice is not None and is_sure(lattice, findings.shape):
        slug, said = (
            "near-regular",
            f"{'near-regular' if lattice.area else 'rows'}, {words(lattice)}",
        )
        vectors = four_numbers(lattice)
        refused = _strained(vectors, canvas)
        if refused:
            slug, said = "quilting", f"{said}, which do not go around {_size(canvas.shape)}"
            warnings.append(refused)
        elif findings.exact:
            parameters["lattice"] = vectors
            if _quickly_cut(canvas) and CanvasLattice(vectors, canvas).strain <= _STIFF:
                slug, parameters = "graphcut", {**WHOLE, **parameters}
    elif findings.scale <= _FINE * shorter:
        slug, said = "patch-sampling", f"fine structure, {findings.scale:.3g} px of {shorter}"
        if findings.colors <= _FEW_COLORS:
            slug, said = "quilting", f"{said}, few colors ({findings.colors}), not to be mixed"
        elif _quickly_cut(canvas):
            slug = "graphcut"
            parameters = {} if findings.scale <= _GRAIN * shorter else _whole(findings, canvas)
    else:
        slug, said = "graphcut", f"irregular structure of {findings.scale:.3g} px"
        if _quickly_cut(canvas) or _is_small(findings.shape):
            parameters = _whole(findings, canvas)
        else:
            said = f"{said}, {canvas.height * canvas.width / 1e6:.3g} megapixels"
    if "orientations" in parameters:
        said = f"{said}, no way up"
    return Choice(slug, parameters, f"{said}: {slug}", tuple(warnings))


def _whole(findings: Findings, canvas: Canvas) -> dict[str, Any]:
    """The entire sample, also upside down where that looks as right: things come again later."""
    turned = findings.sidedness <= _SIDED and canvas.height * canvas.width <= _TURNED
    return {**WHOLE, **({"orientations": "half-turns"} if turned else {})}


def lays_anywhere(choice: Choice) -> bool:
    """Whether entire samples are laid, and by no lattice."""
    return choice.parameters.get("placement") == "entire" and "lattice" not in choice.parameters


def _quickly_cut(canvas: Canvas) -> bool:
    return canvas.height * canvas.width <= PATIENCE


def _is_small(shape: tuple[int, int]) -> bool:
    return math.prod(shape) <= _SMALL


def choose_for_hole(exemplar: Exemplar, canvas: Canvas) -> Choice:
    """The rule for holes: joints and rows go on, things stay whole, all else is patches.

    Parameters
    ----------
    exemplar : Exemplar
        Its mask leaves the hole out.
    canvas : Canvas
        With known pixels.
    """
    said, lattice, things = "a hole to fill", None, False
    if min(exemplar.shape) >= SMALLEST_ANALYZED and canvas.known_from is not None:
        small, step = smaller_copy(exemplar, LOOK)
        if min(small.shape) >= SMALLEST_ANALYZED:
            lattice = find_lattice(small)
            scale = dominant_scale(small).scale
            things = lattice is None and scale > _FINE * min(small.shape)
            things &= _is_small(exemplar.shape)
    if things:
        said = f"{said}, irregular structure of {scale * step:.3g} px"
        return Choice("graphcut", dict(WHOLE), f"{said}: graphcut")
    if lattice is None or not is_sure(lattice, small.shape):
        return Choice("patch-sampling", {}, f"{said}: patch-sampling")
    found = Lattice(tuple((x * step, y * step) for x, y in lattice.vectors), lattice.confidence)
    vectors, said = four_numbers(found), f"{said}, {words(found)}"
    if _strained(vectors, canvas):
        return Choice("patch-sampling", {}, f"{said}: patch-sampling")
    if _is_small(exemplar.shape) and CanvasLattice(vectors, canvas).strain <= _STIFF:
        return Choice("graphcut", {**WHOLE, "lattice": vectors}, f"{said}: graphcut")
    if not lattice.area:
        return Choice("patch-sampling", {}, f"{said}: patch-sampling")
    parameters = {"lattice": vectors} if step == 1 else {}
    return Choice("near-regular", parameters, f"{said}: near-regular")


def is_sure(lattice: Lattice, shape: tuple[int, int]) -> bool:
    """Whether blocks may be laid by a lattice, or by rows."""
    if len(lattice.vectors) == 1:
        return lattice.confidence >= _ROWS
    return lattice_is_sure(lattice, math.prod(shape))


def _warnings(findings: Findings) -> list[str]:
    """What no method can do with the sample."""
    even, found = findings.evenness, []
    if even.large_forms > _FORMS:
        found.append(
            f"{100 * even.large_forms:.0f} % of the contrast lies in forms larger than an eighth "
            "of the sample: one object, or too few things; show more of the material"
        )
    elif even.light > _LIGHT and even.light_range > _LIGHT_RANGE:
        found.append(
            f"the light changes by {even.light_range:.0f} of 255 levels across the sample; even "
            "it out (--even-light), or crop a part"
        )
    if findings.lattice is None or len(findings.lattice.vectors) == 1:
        times = max(max(growth, 1 / growth) for growth in even.perspective)
        if times > 1:
            found.append(
                f"things are {times:.2g} times as large at one side as at the other, so it was "
                "taken at a slant; straighten it by four corners first (--straighten)"
            )
    return found


def words(lattice: Lattice) -> str:
    """A lattice or rows, and how sure they are."""
    kind = "lattice" if len(lattice.vectors) == 2 else "distance"
    return f"{kind} {courses(lattice)}, confidence {lattice.confidence:g}"


def _size(shape: tuple[int, int]) -> str:
    return f"{shape[1]}x{shape[0]}"


def _strained(vectors: tuple[float, ...], canvas: Canvas) -> str:
    """Why a lattice does not go around a canvas, and which size would do; "" where it does."""
    try:
        CanvasLattice(vectors, canvas, VISIBLE_STRAIN)
    except InvalidInputError as error:
        return str(error)
    return ""
