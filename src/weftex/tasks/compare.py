"""Every method on one sample, side by side: pictures, sources, figures, times."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from time import perf_counter
from typing import TYPE_CHECKING, Any

from weftex.canvas import as_canvas
from weftex.errors import InvalidInputError, UnsupportedError
from weftex.methods import METHODS
from weftex.pages.html import Page
from weftex.progress import Progress
from weftex.quality.assess import Assessment, assess
from weftex.random import seed_number
from weftex.tasks.auto import Auto, AutoModel, Choice
from weftex.tasks.method_names import make_method
from weftex.tasks.synthesize import load_exemplar

if TYPE_CHECKING:
    from collections.abc import Sequence

    from weftex.exemplar import Exemplar
    from weftex.progress import ProgressCallback
    from weftex.random import Seed
    from weftex.results.synthesis import Synthesis
    from weftex.tasks.synthesize import Sample

_USUAL = 512  # pixels a side of the output, at most, where no size is given

#: What slow methods are given, and what is said of it.
FAST: dict[str, tuple[dict[str, Any], str]] = {
    "efros-leung": (
        {"search": "pca"},
        "with search=pca; all windows, its default, would take about three times as long",
    ),
}


@dataclass(frozen=True, eq=False)
class Entry:
    """What one method made of the sample.

    Attributes
    ----------
    method : str
        Its name.
    result : Synthesis or None
        None where it cannot do this.
    seconds : float
        That fitting and making took.
    assessment : Assessment or None
        The figures.
    note : str
        What its parameters were chosen for, or why there is no result.
    """

    method: str
    result: Synthesis | None
    seconds: float
    assessment: Assessment | None
    note: str

    @property
    def rank(self) -> float:
        """The score; endless without one, so that it comes last."""
        score = None if self.assessment is None else self.assessment.score
        return float("inf") if score is None else score

    def as_dict(self) -> dict[str, Any]:
        """Return all but the picture as JSON has it."""
        return {
            "method": self.method,
            "seconds": round(self.seconds, 3),
            "note": self.note,
            "figures": None if self.assessment is None else self.assessment.as_dict(),
            "provenance": None if self.result is None else self.result.provenance,
        }


@dataclass(frozen=True, eq=False)
class Comparison(Page):
    """What `compare` finds.

    Attributes
    ----------
    exemplar : Exemplar
        The sample.
    shape : (int, int)
        Height and width of the outputs.
    seed : int
        Of all of them.
    choice : Choice
        What "auto" would take, and why.
    entries : tuple of Entry
        Best score first, then those without a result.
    """

    exemplar: Exemplar
    shape: tuple[int, int]
    seed: int
    choice: Choice
    entries: tuple[Entry, ...]

    def as_dict(self) -> dict[str, Any]:
        """Return all figures as numbers, texts, lists, dicts and None, as JSON has them."""
        return {
            "sample": self.exemplar.name,
            "height": self.shape[0],
            "width": self.shape[1],
            "seed": self.seed,
            "auto": dataclasses.asdict(self.choice),
            "methods": [entry.as_dict() for entry in self.entries],
        }

    def html(self) -> str:
        """Return a page that needs nothing but itself."""
        from weftex.pages.compare import page

        return page(self)


def compare(
    sample: Sample,
    size: int | tuple[int, int] | None = None,
    *,
    methods: Sequence[str] | None = None,
    seed: Seed = None,
    tileable: bool | str = False,
    threads: int | None = None,
    progress: ProgressCallback | None = None,
) -> Comparison:
    """Make the same from one sample with every method, and measure each.

    Slow methods get their fast options (`FAST`), and the result says so. A method that cannot do
    it says why in its place.

    Parameters
    ----------
    sample : path, array, PIL image or Exemplar
        The material; see `weftex.load_exemplar`.
    size : int or (int, int), optional
        Height and width of the outputs; twice the sample by default, at most 512.
    methods : sequence of str, optional
        Names in `weftex.METHODS`; all by default.
    seed, tileable, threads
        As for `weftex.synthesize`.
    progress : callable, optional
        See `weftex.progress.ProgressCallback`; it counts methods, and is also asked within each.

    Returns
    -------
    Comparison

    Raises
    ------
    InvalidInputError
        If a method is unknown or named twice, or the sample or the size cannot be used.

    Examples
    --------
    >>> import weftex
    >>> found = compare("sample:weave", 96, methods=["best-tile", "quilting"], seed=1)
    >>> [entry.method for entry in found.entries], found.choice.method
    (['quilting', 'best-tile'], 'near-regular')
    """
    names = list(METHODS) if methods is None else list(methods)
    for name in names:
        METHODS[name]  # raises for an unknown one
    if not names or len(set(names)) < len(names):
        raise InvalidInputError(f"methods is {', '.join(names)!r}; name each once, at least one")
    exemplar = load_exemplar(sample)
    if size is None:
        size = (min(_USUAL, 2 * exemplar.shape[0]), min(_USUAL, 2 * exemplar.shape[1]))
    canvas, number = as_canvas(size, tileable), seed_number(seed)
    done: list[Entry] = []
    count = Progress(progress, len(names), "methods", lambda: done and _last(done))
    options: dict[str, Any] = {"seed": number, "threads": threads, "progress": count.within()}
    for name in names:
        parameters, note = FAST.get(name, ({}, ""))
        start = perf_counter()
        try:
            method = make_method(name, parameters)
            method.require(canvas)
            result = method.fit(exemplar).sample(canvas, **options)
            result.image  # rendering is part of the work  # noqa: B018
        except (InvalidInputError, UnsupportedError) as error:
            done.append(Entry(name, None, perf_counter() - start, None, str(error)))
        else:
            took = perf_counter() - start
            done.append(Entry(name, result, took, assess(exemplar, result), note))
        count.advance(1)
    choice = AutoModel(Auto(), exemplar).choose(canvas)
    ranked = sorted(done, key=lambda entry: (entry.result is None, entry.rank))
    return Comparison(exemplar, canvas.shape, number, choice, tuple(ranked))


def _last(done: list[Entry]) -> Any:
    """The last picture there is."""
    made = [entry.result for entry in done if entry.result is not None]
    return made[-1].image if made else None
