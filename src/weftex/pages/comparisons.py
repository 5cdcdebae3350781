"""Every method on one sample, side by side: images, sources, figures, times; one HTML file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from html import escape
from time import perf_counter
from typing import Any

import numpy as np

from weftex import (
    METHODS,
    Assessment,
    Exemplar,
    InvalidInputError,
    Synthesis,
    UnsupportedError,
    assess,
    load_exemplar,
)
from weftex.canvas import as_canvas
from weftex.errors import wrong_value
from weftex.naming import make_method
from weftex.pages.html import Page, document, number, parameters, pictures, show, small, table
from weftex.progress import Progress, ProgressCallback, listening
from weftex.quality import FIGURES, SCORE, as_shown
from weftex.random import seed_number
from weftex.registry import AUTO
from weftex.tasks.auto import Auto, AutoModel
from weftex.tasks.auto.rule import Choice

_COLORS = "false colors by place in the sample: more red to the right, more green downwards"


@dataclass(frozen=True, eq=False)
class Entry:
    """The result of one method.

    Attributes
    ----------
    method : str
        Its name.
    result : Synthesis or None
        None where the method cannot make it.
    seconds : float
        Wall-clock time of fitting and sampling.
    assessment : Assessment or None
        Measures and score of the result.
    note : str
        Why there is no result.
    """

    method: str
    result: Synthesis | None
    seconds: float
    assessment: Assessment | None
    note: str

    @property
    def rank(self) -> float:
        """The score, or infinity without one."""
        score = None if self.assessment is None else self.assessment.score
        return float("inf") if score is None else score

    def as_dict(self) -> dict[str, Any]:
        """Return everything except the picture, ready for JSON."""
        return {
            "method": self.method,
            "seconds": round(self.seconds, 3),
            "note": self.note,
            "figures": None if self.assessment is None else self.assessment.as_dict(),
            "provenance": None if self.result is None else self.result.provenance,
        }


@dataclass(frozen=True, eq=False)
class Comparison(Page):
    """Results of several methods, as returned by `weftex.pages.compare`.

    Attributes
    ----------
    exemplar : Exemplar
        The sample.
    shape : (int, int)
        Height and width of the outputs.
    seed : int
        Seed of all outputs.
    choice : Choice
        The method that "auto" would choose, and why.
    entries : tuple of Entry
        Best score first, then those without a result.
    """

    exemplar: Exemplar
    shape: tuple[int, int]
    seed: int
    choice: Choice
    entries: tuple[Entry, ...]

    def __repr__(self) -> str:
        scores = ", ".join(f"{one.method} {one.rank:.2f}" for one in self.entries)
        return f"<Comparison on {self.exemplar.name!r}, by score: {scores}>"

    @property
    def contradiction(self) -> str:
        """Why "auto" chooses another method than the one with the best score; "" if it does not."""
        best, auto = self.entries[0], self.choice.method
        mine = [entry for entry in self.entries if entry.method in (auto, AUTO)]
        if best in mine or not mine or best.rank == mine[0].rank:
            return ""
        return (
            f"{best.method} has a better score than auto's {auto} ({best.rank:.2f}, "
            f"{mine[0].rank:.2f}), but auto chooses before it makes anything, by the sample alone"
        )

    def as_dict(self) -> dict[str, Any]:
        """Return all figures as numbers, texts, lists, dicts and None, as JSON has them."""
        return {
            "sample": self.exemplar.name,
            "height": self.shape[0],
            "width": self.shape[1],
            "seed": self.seed,
            "auto": self.choice.as_dict(),
            "methods": [entry.as_dict() for entry in self.entries],
        }

    def html(self) -> str:
        """Return the whole page as one file."""
        name, (height, width) = self.exemplar.name, self.shape
        limited = {name: figure for name, figure in FIGURES.items() if figure.limit is not None}
        head = ("Method", "Score", "Seconds", *(figure.title for figure in limited.values()))
        limits = "; ".join(f"{figure.title} {figure.within()}" for figure in limited.values())
        parts = [
            f'<p class="verdict">Auto: {escape(self.choice.reason)}</p>',
            *map(small, [one for one in (self.contradiction, *self.choice.warnings) if one]),
            f"<p>All made {width}x{height} pixels from this sample, with seed {self.seed}.</p>",
            show(as_shown(self.exemplar, self.exemplar.pixels), "Sample", name),
            "<h2>Measures</h2>",
            table((self._row(entry, [*limited]) for entry in self.entries), head),
            small(
                f"Score: {SCORE} Measures beyond their limits are in color. Limits: {limits}. A "
                "dash: cannot be measured."
            ),
        ]
        for entry in self.entries:
            parts += self._section(entry)
        return document(f"{len(self.entries)} methods on {name}", parts)

    def _row(self, entry: Entry, names: list[str]) -> str:
        """A method and its figures, those beyond their limits marked."""
        link = f'<a href="#{entry.method}">{entry.method}</a>'
        made_it = any(one.method == AUTO for one in self.entries)  # with parameters of its own
        mark = {AUTO: self.choice.method} if made_it else {self.choice.method: AUTO}
        link += f" ({mark[entry.method]})" if entry.method in mark else ""
        row, found = f'<th scope="row">{link}</th>', entry.assessment
        if found is None:
            return f'{row}<td colspan="{2 + len(names)}">{escape(entry.note)}</td>'
        cells = [("", number(found.score)), ("", number(entry.seconds))]
        for name in names:
            over = "over" if name in found.flags else ""
            cells.append((over, number(getattr(found, name), FIGURES[name])))
        return row + "".join(f'<td class="number {kind}">{text}</td>' for kind, text in cells)

    def _section(self, entry: Entry) -> list[str]:
        """The result of a method, and its parameters."""
        head = f'<h2 id="{entry.method}">{entry.method}</h2>'
        if entry.result is None or entry.assessment is None:
            return [head, f"<p>It cannot make this: {escape(entry.note)}.</p>"]
        image = as_shown(self.exemplar, entry.result.image)
        shown = (image, entry.method, "the result"), (entry.result.draw(), "Source", _COLORS)
        return [
            head,
            f"<p>{escape(entry.assessment.verdict())} {entry.seconds:.2f} s.</p>",
            pictures(shown),
            parameters("Parameters", entry.result.provenance),
        ]


_USUAL = 512  # pixels a side of the output, at most, where no size is given


def compare(
    sample: Any,
    size: int | tuple[int, int] | None = None,
    *,
    methods: Sequence[str] | None = None,
    seed: int | np.random.Generator | None = None,
    tileable: bool | str = False,
    threads: int | None = None,
    progress: ProgressCallback | None = None,
) -> Comparison:
    """Synthesize one output with every method, and measure each.

    If a method refuses the sample, its entry has the reason.

    Parameters
    ----------
    sample : path, array, PIL image or Exemplar
        The material; see `weftex.load_exemplar`.
    size : int or (int, int), optional
        Height and width of the outputs; twice the sample by default, at most 512.
    methods : sequence of str, optional
        Names in `weftex.METHODS`, or "auto"; all of them by default.
    seed, tileable, threads
        As for `weftex.synthesize`.
    progress : callable, optional
        See `weftex.progress.ProgressCallback`; it counts methods and can cancel within each.

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
    (['quilting', 'best-tile'], 'graphcut')
    """
    if methods is not None and not isinstance(methods, (list, tuple)):
        raise wrong_value("methods", methods, "a list of names")
    names = [AUTO, *METHODS] if methods is None else list(methods)
    made = {name: make_method(name, {}) for name in names}  # raises for an unknown one
    if not names or len(made) < len(names):
        raise InvalidInputError(f"methods is {', '.join(names)!r}; name each once, at least one")
    exemplar = load_exemplar(sample)
    if size is None:
        size = (min(_USUAL, 2 * exemplar.shape[0]), min(_USUAL, 2 * exemplar.shape[1]))
    canvas, number = as_canvas(size, tileable), seed_number(seed)
    done, images = list[Entry](), list[Any]()
    count = Progress(progress, len(names), "methods", lambda: images and images[-1])
    options: dict[str, Any] = {"seed": number, "threads": threads, "progress": count.within()}
    with listening(count.within()):
        for name, method in made.items():
            start = perf_counter()
            count.stage = f"methods, now {name}"
            try:
                method.require(canvas)
                result = method.fit(exemplar).sample(canvas, **options)
                images.append(result.image)  # rendering is part of the work
            except (InvalidInputError, UnsupportedError) as error:
                done.append(Entry(name, None, perf_counter() - start, None, str(error)))
            else:
                took = perf_counter() - start
                done.append(Entry(name, result, took, assess(exemplar, result), ""))
            count.advance(1)
    choice = AutoModel(Auto(), exemplar).choose(canvas)
    for entry in done:
        if entry.method == AUTO and entry.result is not None:  # which may have tried more than one
            used = entry.result.provenance
            because = used["reason"].removeprefix(f"{used['method']}, because ")
            choice = replace(choice, method=used["method"], because=because)
    ranked = sorted(done, key=lambda entry: (entry.result is None, entry.rank))
    return Comparison(exemplar, canvas.shape, number, choice, tuple(ranked))
