"""`auto`: look at the sample, choose the method for it, and say why.

`docs/auto.md` has the rule as a table, with what it was measured against.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from weftex.analysis.canvas_lattice import VISIBLE_STRAIN, CanvasLattice, is_sure
from weftex.analysis.courses import courses
from weftex.analysis.evenness import Evenness, evenness
from weftex.analysis.lattice import Lattice, find_lattice
from weftex.analysis.relief import smaller_copy
from weftex.analysis.scale import dominant_scale
from weftex.canvas import Canvas, as_canvas
from weftex.choice import Choice
from weftex.errors import InvalidInputError
from weftex.exemplar import Exemplar
from weftex.method import Method, Model
from weftex.methods import make_method

if TYPE_CHECKING:
    from weftex.progress import ProgressCallback
    from weftex.random import Seed
    from weftex.results.synthesis import Synthesis

_LOOK = 320  # pixels a side; of larger samples a smaller copy and a part are looked at
_SMALLEST_ANALYZED = 32  # pixels a side of a sample that has something to be analyzed
_FINE = 1 / 12  # scale over the sample's side: a patch of a quarter of it is three things wide
_FEW_COLORS = 32  # drawings, labels: no mixtures of colors
#: Pixels of the output from which `graphcut`, at about 10 s a megapixel, takes too long.
PATIENCE = 2**20
#: What is tried in turn where a method cannot be fitted, as to a sample that is mostly masked.
_OTHERS = ("graphcut", "quilting", "patch-sampling", "ashikhmin")

_LIGHT, _LIGHT_RANGE = 0.25, 40.0  # samples that are lit evenly have up to 0.2 by chance
_FORMS = 0.45  # samples of many things have up to 0.33


@dataclass(frozen=True)
class Findings:
    """What the choice hangs on.

    Attributes
    ----------
    shape : (int, int)
        Height and width of the sample.
    lattice : Lattice or None
        See `weftex.analysis.lattice.find_lattice`.
    exact : bool
        Whether the lattice was found in the sample itself and not in a smaller copy or a part.
    scale : float
        See `weftex.analysis.scale.DominantScale`, in pixels of the sample.
    colors : int
        Different colors; many of more than some thousand.
    evenness : Evenness
        See `weftex.analysis.evenness`.
    """

    shape: tuple[int, int]
    lattice: Lattice | None
    exact: bool
    scale: float
    colors: int
    evenness: Evenness


@dataclass(frozen=True)
class Auto(Method):
    """The method that suits the sample and the canvas best.

    Examples
    --------
    >>> import weftex
    >>> made = weftex.Auto().fit(weftex.load_exemplar("sample:tiles")).sample(300, seed=7)
    >>> made.provenance["method"], made.provenance["reason"]
    ('near-regular', 'near-regular, lattice 31.1 x 102.2 px, confidence 0.87: near-regular')
    """

    slug: ClassVar[str] = "auto"
    title: ClassVar[str] = "Chosen by the sample"
    paper: ClassVar[str] = "A choice among the other methods; docs/auto.md has the rule"
    supports: ClassVar[frozenset[str]] = frozenset({"wrap", "known", "guide"})

    def fit_exemplar(self, exemplar: Exemplar) -> AutoModel:
        """Return a model that chooses when it knows what to make; the sample is analyzed once."""
        return AutoModel(self, exemplar)


class AutoModel(Model):
    """A sample; `sample` chooses the method for what is to be made.

    Parameters
    ----------
    method : Auto
        It has no parameters.
    exemplar : Exemplar
        The sample.
    """

    def __init__(self, method: Auto, exemplar: Exemplar) -> None:
        self.method, self.exemplar = method, exemplar
        self._models: dict[str, Model] = {}

    @cached_property
    def findings(self) -> Findings:
        """What the sample is like."""
        return look(self.exemplar)

    def choose(self, size: Canvas | int | tuple[int, int]) -> Choice:
        """The method for a canvas, and why."""
        canvas = as_canvas(size)
        if canvas.guide is not None:
            return Choice("refinement", {}, "a guide to follow: refinement")
        if canvas.known is not None:
            return choose_for_hole(self.exemplar, canvas)
        return choose(self.findings, canvas)

    def chosen(self, size: Canvas | int | tuple[int, int]) -> tuple[Choice, Model]:
        """The choice and the fitted method; the next one where a method cannot be fitted."""
        first = self.choose(size)
        failure: InvalidInputError | None = None
        for slug in (first.method, *(other for other in _OTHERS if other != first.method)):
            choice = first
            if failure is not None:
                said = f"{first.reason}, which this sample does not do ({failure}): {slug}"
                choice = Choice(slug, {}, said, first.warnings)
            key = repr((choice.method, choice.parameters))
            try:
                if key not in self._models:
                    self._models[key] = make_method(slug, choice.parameters).fit(self.exemplar)
                return choice, self._models[key]
            except InvalidInputError as error:
                failure = failure or error
        raise failure or InvalidInputError("no method can be fitted to this sample")

    def sample(
        self,
        size: Canvas | int | tuple[int, int],
        *,
        seed: Seed = None,
        tileable: bool | str = False,
        threads: int | None = None,
        progress: ProgressCallback | None = None,
    ) -> Synthesis:
        """Make an output with the method that is chosen for it.

        The parameters are those of every model. The result's provenance has the method with its
        parameters, so that it can be made again by name, and the reason.
        """
        canvas = as_canvas(size, tileable)
        self.method.require(canvas)
        choice, model = self.chosen(canvas)
        made = model.sample(canvas, seed=seed, threads=threads, progress=progress)
        made.provenance["reason"] = choice.reason
        if choice.warnings:
            made.provenance["warnings"] = list(choice.warnings)
        return made


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
    >>> flat = Evenness(0.0, 0.0, 0.0, (1.0, 1.0))
    >>> grass = Findings((256, 256), None, True, 11.5, 5000, flat)
    >>> str(choose(grass, Canvas(512, 512)))
    'fine structure, 11.5 px of 256: patch-sampling'
    """
    shorter, lattice = min(findings.shape), findings.lattice
    area = canvas.height * canvas.width
    warnings = tuple(_warnings(findings))
    parameters: dict[str, Any] = {}
    if shorter < _SMALLEST_ANALYZED:
        slug, said = "graphcut", f"too small to be analyzed, {_size(findings.shape)}"
    elif lattice is not None and is_sure(lattice, math.prod(findings.shape)):
        slug, said = "near-regular", f"near-regular, {_words(lattice)}"
        vectors = tuple(part for vector in lattice.vectors for part in vector)
        strain = _strain(vectors, canvas)
        if strain > VISIBLE_STRAIN:
            said += f", which {_size(canvas.shape)} would strain by {100 * strain:.0f} %"
            slug = "quilting"
        elif findings.exact:
            parameters["lattice"] = vectors
    elif lattice is not None and len(lattice.vectors) == 1:
        slug, said = "quilting", f"rows, {_words(lattice)}"
    elif findings.scale <= _FINE * shorter:
        slug, said = "patch-sampling", f"fine structure, {findings.scale:.3g} px of {shorter}"
        if findings.colors <= _FEW_COLORS:
            slug, said = "quilting", f"{said}, few colors ({findings.colors}), not to be mixed"
    else:
        slug, said = "graphcut", f"irregular structure of {findings.scale:.3g} px"
    if slug == "graphcut" and area > PATIENCE and shorter >= 3:
        megapixels = f"{area / 1e6:.3g} megapixels would take graphcut"
        minutes = 10 * area / 1e6 / 60
        said += f"; {megapixels} {f'{minutes:.0f} minutes' if minutes >= 1.5 else 'too long'}"
        slug = "quilting"
    return Choice(slug, parameters, f"{said}: {slug}", warnings)


def choose_for_hole(exemplar: Exemplar, canvas: Canvas) -> Choice:
    """The rule for holes: joints of a sure lattice go on, anything else is laid in patches.

    Parameters
    ----------
    exemplar : Exemplar
        Its mask leaves the hole out.
    canvas : Canvas
        With known pixels.
    """
    said, lattice = "a hole to fill", None
    if min(exemplar.shape) >= _SMALLEST_ANALYZED and canvas.known_from is not None:
        small, step = smaller_copy(exemplar, _LOOK)
        if min(small.shape) >= _SMALLEST_ANALYZED:
            lattice = find_lattice(small)
    if lattice is None or not is_sure(lattice, math.prod(small.shape)):
        return Choice("patch-sampling", {}, f"{said}: patch-sampling")
    found = Lattice(tuple((x * step, y * step) for x, y in lattice.vectors), lattice.confidence)
    vectors = tuple(part for vector in found.vectors for part in vector)
    if _strain(vectors, canvas) > VISIBLE_STRAIN:
        return Choice("patch-sampling", {}, f"{said}, {_words(found)}: patch-sampling")
    parameters = {"lattice": vectors} if step == 1 else {}
    return Choice("near-regular", parameters, f"{said}, {_words(found)}: near-regular")


def look(exemplar: Exemplar) -> Findings:
    """Analyze a sample for `choose`, in about 0.2 s, or a second where it is of some megapixels.

    A sample of more than 320 pixels a side is averaged down; where that shows no lattice, a part
    of it is looked at as it is, because fine lattices are lost in averages.

    Parameters
    ----------
    exemplar : Exemplar
        The sample.
    """
    small, step = smaller_copy(exemplar, _LOOK)
    if min(small.shape) < _SMALLEST_ANALYZED:
        return Findings(exemplar.shape, None, True, 1.0, _colors(small), Evenness(0, 0, 0, (1, 1)))
    lattice, exact = find_lattice(small), step == 1
    scale = dominant_scale(small, lattice).scale
    if lattice is not None and step > 1:
        vectors = tuple((x * step, y * step) for x, y in lattice.vectors)
        lattice = Lattice(vectors, lattice.confidence)
    elif step > 1:
        lattice = find_lattice(_part(exemplar))
    return Findings(
        shape=exemplar.shape,
        lattice=lattice,
        exact=exact,
        scale=round(scale * step, 2),
        colors=_colors(small if step == 1 else _part(exemplar)),
        evenness=evenness(small),
    )


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
            "it out, or crop a part"
        )
    if findings.lattice is None or len(findings.lattice.vectors) == 1:
        times = max(max(growth, 1 / growth) for growth in even.perspective)
        if times > 1:
            found.append(
                f"things are {times:.2g} times as large at one side as at the other, so it was "
                "taken at a slant; straighten it first"
            )
    return found


def _words(lattice: Lattice) -> str:
    kind = "lattice" if len(lattice.vectors) == 2 else "distance"
    return f"{kind} {courses(lattice)}, confidence {lattice.confidence:g}"


def _size(shape: tuple[int, int]) -> str:
    return f"{shape[1]}x{shape[0]}"


def _strain(vectors: tuple[float, ...], canvas: Canvas) -> float:
    if not any(canvas.wrap):
        return 0.0
    return CanvasLattice(vectors, canvas).strain


def _part(exemplar: Exemplar) -> Exemplar:
    """The middle of the sample; with a mask, of what may be used."""
    usable = np.ones(exemplar.shape, bool) if exemplar.mask is None else exemplar.mask
    corner = []
    for axis in (0, 1):
        places = np.flatnonzero(usable.any(axis=1 - axis))
        side = exemplar.shape[axis]
        middle = (int(places[0]) + int(places[-1]) + 1) // 2
        corner.append(max(0, min(middle - _LOOK // 2, side - _LOOK)))
    box = tuple(slice(at, at + _LOOK) for at in corner)
    mask = None if exemplar.mask is None or not exemplar.mask[box].any() else exemplar.mask[box]
    levels = np.ascontiguousarray(exemplar.matching()[box])
    return Exemplar(levels, mask=mask, alpha=False, name=exemplar.name)


def _colors(exemplar: Exemplar) -> int:
    """Different colors in every third row, which is enough to tell few from many."""
    levels = exemplar.matching()[::3]
    levels = levels.reshape(-1, levels.shape[-1])
    names = np.zeros(len(levels), np.uint64)
    for k in range(min(levels.shape[1], 8)):
        names = names << np.uint64(8) | levels[:, k]
    return len(np.unique(names))
