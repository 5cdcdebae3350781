"""The steps that made a pixel, each with its array and a picture, and who records them."""

from __future__ import annotations

import os
import re
from dataclasses import dataclass, field
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.io.pictures import write_image
from weftex.io.png import data_url

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from weftex.exemplar import Exemplar
    from weftex.results.synthesis import Synthesis


@dataclass(frozen=True)
class Stage:
    """One step of a method at work.

    Attributes
    ----------
    title : str
        What it is.
    caption : str
        What there is to see, with the paper's section, figure or equation.
    array : array
        What the method had in hand.
    picture : uint8 array (H, W, 3)
        A drawing of it.
    """

    title: str
    caption: str
    array: NDArray[Any] = field(repr=False)
    picture: NDArray[np.uint8] = field(repr=False)


class Recorder:
    """Turns the notes of one run into stages; arrays are copied, as they change later."""

    def __init__(self, exemplar: Exemplar, pixel: tuple[int, int]) -> None:
        self.exemplar, self.pixel = exemplar, pixel
        self.found: list[Stage] = []

    def record(self, step: str, facts: dict[str, Any]) -> None:
        """Record a note, see `weftex.notes.Listener`."""
        raise NotImplementedError

    def stages(self) -> list[Stage]:
        """Return the steps that made the pixel, in order; none if it was not made."""
        return self.found


class Explanation:
    """The steps in which a method made a pixel; from `explain`.

    Attributes
    ----------
    result : Synthesis
        The whole output, the same as `synthesize` makes.
    pixel : (int, int)
        The pixel's row and column.
    stages : tuple of Stage
        In the order of the work.
    """

    def __init__(self, result: Synthesis, pixel: tuple[int, int], stages: list[Stage]) -> None:
        self.result, self.pixel, self.stages = result, pixel, tuple(stages)

    def __repr__(self) -> str:
        method = self.result.provenance["method"]
        return f"<Explanation of {method} at {self.pixel}: {', '.join(s.title for s in self)}>"

    def __len__(self) -> int:
        return len(self.stages)

    def __iter__(self) -> Iterator[Stage]:
        return iter(self.stages)

    def __getitem__(self, which: int | str) -> Stage:
        """Return a stage by its number or its title."""
        if isinstance(which, str):
            return {stage.title: stage for stage in self.stages}[which]
        return self.stages[which]

    def _repr_html_(self) -> str:
        figures = "".join(
            f'<figure style="display:inline-block;vertical-align:top;max-width:17em;margin:0.5em">'
            f'<img src="{data_url(s.picture)}" alt="{escape(s.title)}" '
            'style="max-width:100%;image-rendering:pixelated">'
            f"<figcaption><b>{escape(s.title)}</b> {escape(s.caption)}</figcaption></figure>"
            for s in self.stages
        )
        return f"<div>{figures}</div>"

    def save(self, folder: str | os.PathLike[str]) -> list[Path]:
        """Write the pictures, as `01-canvas.png` and so on, and the captions as `captions.txt`."""
        folder = Path(folder)
        folder.mkdir(parents=True, exist_ok=True)
        paths, lines = [], []
        for number, stage in enumerate(self.stages, 1):
            name = f"{number:02d}-{re.sub('[^a-z0-9]+', '-', stage.title.lower())}.png"
            write_image(folder / name, stage.picture)
            paths.append(folder / name)
            lines.append(f"{name}: {stage.title}. {stage.caption}")
        captions = folder / "captions.txt"
        captions.write_text("\n".join(lines) + "\n", encoding="utf-8")
        return [*paths, captions]

    def strip(self, height: int = 160) -> NDArray[np.uint8]:
        """Return all pictures side by side, scaled to a height: (height, W, 3)."""
        gap = np.full((height, 6, 3), 255, np.uint8)
        row: list[NDArray[np.uint8]] = []
        for stage in self.stages:
            rows, columns = stage.picture.shape[:2]
            width = max(1, round(columns * height / rows))
            y, x = (np.arange(n) * m // n for n, m in ((height, rows), (width, columns)))
            row += [stage.picture[np.ix_(y, x)], gap]
        return np.concatenate(row[:-1], axis=1)
