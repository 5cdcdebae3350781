"""`auto`: analyze the sample, choose a method for it, and say why.

`docs/background/auto.md` has the rule as a table, with what it was measured against.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar

from weftex.analysis.canvas_lattice import FITTING_STRAIN, VISIBLE_STRAIN, Around, fitting_sizes
from weftex.analysis.lattice import Lattice
from weftex.canvas import FAR, Canvas, as_canvas
from weftex.endless.boxes import Box, PlaneRequest
from weftex.errors import InvalidInputError
from weftex.exemplar import Exemplar
from weftex.method import Method, Model
from weftex.methods.lattices import LatticeModel
from weftex.naming import make_method
from weftex.parameters import parameter
from weftex.progress import ProgressCallback, counted
from weftex.results.synthesis import Synthesis
from weftex.tasks.auto.findings import Findings, look, with_full
from weftex.tasks.auto.rule import Choice, choose, choose_for_hole, may_place

#: Tried in turn where a method cannot be fitted, as to a sample that is mostly masked.
_OTHERS = ("graphcut", "quilting", "patch-sampling", "ashikhmin")


@dataclass(frozen=True)
class Auto(Method):
    """Chooses the method that suits the sample and the canvas.

    The first output analyzes the sample. A method is chosen for each canvas, and fitted once.

    Examples
    --------
    >>> import weftex
    >>> made = weftex.Auto().fit(weftex.load_exemplar("sample:tiles")).sample(300, seed=7)
    >>> made.provenance["method"], made.provenance["reason"]
    ('graphcut', 'graphcut, because the sample has a lattice of 31.1 x 102.2 px (confidence 0.95)')
    """

    slug: ClassVar[str] = "auto"
    title: ClassVar[str] = "Chooses a method for the sample"
    paper: ClassVar[str] = "A choice among the other methods; docs/background/auto.md has the rule"
    supports: ClassVar[frozenset[str]] = frozenset({"wrap", "known", "guide"})

    effort: str = parameter(
        "normal",
        "best: a better, slower method for outputs above 4096x4096 of samples with a lattice",
        choices=("normal", "best"),
    )

    def fit_exemplar(self, exemplar: Exemplar) -> AutoModel:
        """Return a model that chooses for each canvas; the first one analyzes the sample."""
        return AutoModel(self, exemplar)


class AutoModel(Model):
    """A sample; `sample` chooses the method for each canvas, `upright` without turned copies."""

    def __init__(self, method: Auto, exemplar: Exemplar, *, upright: bool = False) -> None:
        self.method, self.exemplar, self._effort = method, exemplar, method.effort
        self._upright = upright
        self._models: dict[str, Model] = {}

    @cached_property
    def findings(self) -> Findings:
        """The analysis of the sample."""
        found = look(self.exemplar)
        return replace(found, sidedness=(1.0, 1.0)) if self._upright else found

    @cached_property
    def _exactly(self) -> Findings:
        return with_full(self.findings, self.exemplar)

    @property
    def lattice(self) -> Lattice | None:
        """The lattice or rows that tileable outputs must fit, if those of the sample are sure."""
        found = self._exactly
        if found.lattice is None or not may_place(found.lattice, found.shape):
            return None
        return found.full or found.lattice

    def choose(self, size: Canvas | Around | int | tuple[int, int]) -> Choice:
        """Return the rule's method for a canvas or a plane, and why."""
        if isinstance(size, Around):
            return choose(self._exactly, size)
        canvas = as_canvas(size)
        if canvas.guide is not None:
            return Choice("graphcut", {}, "there is a guide to follow")
        if canvas.known is not None:
            return choose_for_hole(self.exemplar, canvas)
        return choose(self._exactly, canvas, patient=self._effort == "best")

    def chosen(self, size: Canvas | Around | int | tuple[int, int]) -> tuple[Choice, Model]:
        """Return the rule's choice and its model, or the next method that can be fitted."""
        failure: InvalidInputError | None = None
        with counted(2, "analysis") as step:
            first = self.choose(size)
            step(1)
            for slug in (first.method, *(other for other in _OTHERS if other != first.method)):
                choice = first
                if failure is not None:
                    because = f"{first.because}, but {first.method} cannot use it ({failure})"
                    choice = Choice(slug, {}, because, first.warnings)
                try:
                    return choice, self._fitted(choice)
                except InvalidInputError as error:
                    failure = failure or error
        raise failure or InvalidInputError("no method can use this sample")

    def _fitted(self, choice: Choice) -> Model:
        key = repr((choice.method, choice.parameters))
        if key not in self._models:
            method = make_method(choice.method, choice.parameters)
            self._models[key] = method.fit(self.exemplar)
        return self._models[key]

    def make(
        self, canvas: Canvas, seed: int, threads: int, progress: ProgressCallback | None
    ) -> Synthesis:
        """Make an output with the method that is chosen for it.

        The result's provenance has the method with its parameters, so that it can be made again by
        name, and the reason.
        """
        choice, model = self.chosen(canvas)
        made = model.sample(canvas, seed=seed, threads=threads, progress=progress)
        return _with_reason(made, choice)

    def make_window(
        self, box: Box, asked: PlaneRequest, progress: ProgressCallback | None = None
    ) -> Synthesis:
        """See `Model.make_window`: the rule's choice for a plane, whatever the window."""
        period = asked.period
        choice, model = self.chosen(Around(*(period or (FAR, FAR)), wrap=(period is not None,) * 2))
        return _with_reason(model.make_window(box, asked, progress), choice)


__all__ = ["Auto", "AutoModel", "Findings", "choose", "choose_for_hole", "look"]


def _with_reason(made: Synthesis, choice: Choice) -> Synthesis:
    made.provenance["reason"] = choice.reason
    if choice.warnings:
        made.provenance["warnings"] = list(choice.warnings)
    return made


def fitting_canvas(canvas: Canvas, exemplar: Exemplar, method: Method) -> Canvas:
    """Return the canvas in the nearest size that fits; as it is if the sample has no lattice."""
    if not any(canvas.wrap):
        raise InvalidInputError("fit has no effect without tileable")
    if canvas.guide is not None or canvas.known is not None:
        raise InvalidInputError("fit has no effect: a guide or a photo sets the size")
    model = method.fit(exemplar)
    own = model.vectors if isinstance(model, LatticeModel) else None
    found = own or AutoModel(Auto(), exemplar).lattice
    if found is None:
        return canvas
    for limit in (FITTING_STRAIN, VISIBLE_STRAIN):
        for height, width in fitting_sizes(tuple(found), canvas, limit)[:1]:
            return replace(canvas, height=height, width=width)
    return canvas
