"""The analysis of a sample: scale, lattice, evenness, tiling, and the method for it."""

from __future__ import annotations

import dataclasses
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from weftex.analysis.autocorrelations import autocorrelations
from weftex.analysis.canvas_lattice import checked_lattice
from weftex.analysis.lattice import Lattice, Rated, lattice_in, rate_lattices
from weftex.analysis.overlay import courses
from weftex.analysis.properties import Evenness, regularity
from weftex.analysis.scale import structure_scale
from weftex.errors import InvalidInputError
from weftex.exemplar import Exemplar, Sample, load_exemplar
from weftex.progress import counted
from weftex.quality import borders_of
from weftex.registry import METHODS
from weftex.tasks.auto import Auto
from weftex.tasks.auto.rule import Choice

_WIDTH = 100  # characters of a line
_RUNNERS_UP = 4


@dataclass(frozen=True)
class Ratings:
    """Lattices of a sample, rated as in section 3.3 of the thesis by D. López Recas (2011).

    Attributes
    ----------
    found, given : Rated or None
        The lattice that was found; the lattice that was passed to `analyze`.
    runners_up : tuple of Rated
        Other possible lattices, best first.
    """

    found: Rated | None
    given: Rated | None
    runners_up: tuple[Rated, ...]


@dataclass(frozen=True)
class Analysis:
    """The analysis of a sample; `as_dict` gives plain values, `str` the output of the command.

    Attributes
    ----------
    name, dtype, maps : str, str, tuple of str
        Name of the sample; type of its pixels; names of its maps.
    height, width, channels : int
        Number of rows; number of columns; number of channels.
    alpha : bool
        Whether the last channel is alpha.
    scale : float
        Size of the features, such as pebbles or bricks, in pixels.
    confidence : float
        Confidence of the scale, 0 to 1. The lattice has its own, `lattice.confidence`.
    scale_source : {"lattice", "period", "things", "none"}
        From what the scale was measured: the lattice, the strongest period, or single features.
    regularity : float
        Correlation of the sample with itself after its best shift; 1 is an exact tiling.
    lattice : Lattice or None
        Vectors after which the sample repeats, and their confidence. `GraphCut`, `NearRegular` and
        `BestTile` take it as `lattice=`; `Auto` finds it itself.
    ratings : Ratings
        Ratings of the lattice and of others.
    border_steps : (float, float)
        Change of color at the border divided by that inside, down and across; 1 is no seam.
    tiles : (bool, bool)
        Whether the sample is tileable, down and across, as `tile --check` says.
    evenness : Evenness
        Uneven light and large forms; `choice.warnings` has them in words.
    choice : Choice
        The method that "auto" chooses for twice the sample's size, and why.
    windows : dict of str to int or None
        Default window width of each pixel method; None for a method that cannot use this sample.
    """

    name: str
    height: int
    width: int
    channels: int
    dtype: str
    alpha: bool
    maps: tuple[str, ...]
    scale: float
    confidence: float
    scale_source: str
    regularity: float
    lattice: Lattice | None
    ratings: Ratings
    border_steps: tuple[float, float]
    tiles: tuple[bool, bool]
    evenness: Evenness
    choice: Choice
    windows: dict[str, int | None]

    def as_dict(self) -> dict[str, Any]:
        """Return everything as numbers, texts, lists and dicts, ready for JSON."""
        return dataclasses.asdict(self) | {"choice": self.choice.as_dict()}

    def __repr__(self) -> str:
        size = f"{self.width}x{self.height}"
        return f"<Analysis of {self.name!r}, {size}: scale {self.scale:g} px; {self.choice}>"

    def __str__(self) -> str:
        down, right = (f"{step:g}" for step in self.border_steps)
        across = (
            f"steps across the border over those inside: {down} downwards, {right} to the right"
        )
        words = {(True, True): "yes", (True, False): "downwards only"}
        words |= {(False, True): "to the right only", (False, False): "no"}
        if any(self.tiles):
            across += "; if it was made to, use --tileable-sample" if all(self.tiles) else ""
        certainty = f"of its {self.scale_source}, confidence {self.confidence:g}"
        if self.scale_source == "none":
            certainty = "(no clear peak)"
        kind = f"{self.width}x{self.height}, {self.channels} x {self.dtype}"
        rows = [
            (self.name, kind + (" with alpha" if self.alpha else "")),
            *([("maps", ", ".join(self.maps))] if self.maps else []),
            ("scale", f"{self.scale:g} px {certainty}".replace("things", "features")),
            ("regularity", f"{self.regularity:g}"),
            *self._lattices(),
            ("tileable", f"{words[self.tiles]} ({across})"),
            ("auto", self.choice.reason),
            *(("note", warning) for warning in self.choice.warnings),
            *(("window", f"{'none' if width is None else f'{width} px'} for {slug}")
              for slug, width in self.windows.items()),
        ]  # fmt: skip
        label = max(len(name) for name, _ in rows) + 2
        return "\n".join(
            textwrap.fill(f"{name:{label}}{text}", _WIDTH, subsequent_indent=" " * label)
            for name, text in rows
        )

    def _lattices(self) -> list[tuple[str, str]]:
        """Return the lines on the lattice, a given one, and the runners-up."""
        rated, own, rows = self.ratings, self.lattice, [("lattice", "none")]
        if own is not None:
            rows = [("lattice", f"{_words(own)}, confidence {own.confidence:g}")]
            rows.append(("vectors", f"{_numbers(own)} px"))
        if rated.found is not None:
            rows.append(("goodness", _goodness(rated.found)))
        if rated.given is not None:
            rows.append(("given", _rated(rated.given)))
        for number, other in enumerate(rated.runners_up, 1):
            rows.append((f"runner-up {number}", _rated(other)))
        return rows


def analyze(sample: Sample, *, lattice: Sequence[float] | str | None = None) -> Analysis:
    """Analyze a sample: scale, lattice, evenness, tiling, and the method for it.

    Parameters
    ----------
    sample : path, array, PIL image or Exemplar
        The material; see `weftex.load_exemplar`.
    lattice : Lattice, (x1, y1, x2, y2) or str, optional
        Also rate this lattice; a text is "x1,y1,x2,y2". For rows, one vector is the step from row
        to row. The other is one pixel long, and has the direction of the rows.

    Returns
    -------
    Analysis

    Raises
    ------
    FileError
        If the sample cannot be read.
    InvalidInputError
        If its pixels cannot be used, a value is out of its range, or the lattice does not fit.

    Examples
    --------
    >>> found = analyze("sample:weave")
    >>> round(found.scale), found.confidence > 0.9, found.tiles
    (12, True, (False, False))
    """
    exemplar = load_exemplar(sample)
    given = None if lattice is None else checked_lattice(lattice, exemplar)
    with counted(7, "analysis") as step:
        model = Auto().fit_exemplar(exemplar)
        look = model.findings
        step(1)
        seen = autocorrelations(exemplar)
        step(2)
        own = look.lattice if look.exact else lattice_in(seen)
        step(1)
        found = structure_scale(exemplar.changed(maps={}), own)  # as `auto` does
        borders = borders_of(exemplar)
        alike = regularity(exemplar)
        step(1)
        rated, others = rate_lattices(exemplar, own, runners_up=_RUNNERS_UP, fields=seen)
        asked = None
        if given is not None:
            asked, _ = rate_lattices(exemplar, given, runners_up=0, fields=seen)
        step(1)
        choice = model.choose((2 * exemplar.shape[0], 2 * exemplar.shape[1]))
    return Analysis(
        name=exemplar.name,
        height=exemplar.shape[0],
        width=exemplar.shape[1],
        channels=exemplar.channels,
        dtype=exemplar.pixels.dtype.name,
        alpha=exemplar.alpha,
        maps=tuple(sorted(exemplar.maps)),
        scale=found.scale,
        confidence=found.confidence,
        scale_source=found.source,
        regularity=alike,
        lattice=own,
        ratings=Ratings(rated, asked, others),
        border_steps=(borders[0].steps, borders[1].steps),
        tiles=(borders[0].badness <= 1, borders[1].badness <= 1),
        evenness=look.evenness,
        choice=choice,
        windows=_windows(exemplar),
    )


def _numbers(lattice: Lattice) -> str:
    """Return a lattice as `--lattice` takes it."""
    return ",".join(f"{number:g}" for number in lattice)


def _goodness(rated: Rated) -> str:
    return f"{rated.goodness:g}: mean {rated.mean:g} over {rated.multiples} multiples"


def _rated(rated: Rated) -> str:
    lattice = Lattice(rated.vectors)
    return f"{_numbers(lattice)} px, {_words(lattice)}; goodness {_goodness(rated)}"


def _words(lattice: Lattice) -> str:
    """Return a lattice or rows in words."""
    said = courses(lattice)
    if len(lattice.vectors) == 2:
        return said
    x, y = lattice.vectors[0]
    return f"{'columns' if abs(x) > abs(y) else 'rows'} {said} apart"


def _windows(exemplar: Exemplar) -> dict[str, int | None]:
    """Return the window of each method by default."""
    result: dict[str, int | None] = {}
    for slug, cls in METHODS.items():
        try:
            width = cls().window_of(exemplar)
        except InvalidInputError:
            width = None
        if width != 0:
            result[slug] = width
    return result
