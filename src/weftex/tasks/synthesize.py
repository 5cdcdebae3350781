"""Make a picture of any size from a sample."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from weftex.canvas import Canvas, as_canvas
from weftex.errors import InvalidInputError, is_whole, wrong_value
from weftex.exemplar import Exemplar, Sample, load_exemplar
from weftex.method import Method, Model
from weftex.naming import make_method
from weftex.progress import Progress, ProgressCallback, listening
from weftex.random import Seed, seed_number
from weftex.registry import AUTO
from weftex.results.synthesis import Synthesis

if TYPE_CHECKING:
    from weftex.quality.score import Rating

_MOST_TRIES = 1000  # outputs of which the best is kept
_REPEATED = 1.25  # sample areas of an output from which `auto` thins landmarks


def synthesize(
    sample: Sample,
    size: Canvas | int | tuple[int, int],
    *,
    method: str | Method = AUTO,
    seed: Seed = None,
    tileable: bool | str = False,
    guide: Sample | None = None,
    sample_guide: Sample | None = None,
    fit: bool = False,
    best_of: int = 1,
    landmarks: str = "auto",
    threads: int | None = None,
    progress: ProgressCallback | None = None,
    **parameters: Any,
) -> Synthesis:
    """Synthesize an image of any size from a sample of a material.

    Parameters
    ----------
    sample : path, array, PIL image or Exemplar
        The material; a folder is a set of aligned maps, "sample:NAME" one that ships with weftex.
    size : int, (int, int) or Canvas
        Height and width of the output in pixels.
    method : str or Method
        A name in `weftex.METHODS`, "auto", or a method with its parameters. "auto" analyzes the
        sample and chooses; the result's `provenance` has the choice and its reason.
    seed : int, numpy Generator or None
        The same seed gives the same bytes, with any number of threads. None draws a seed; from a
        Generator, one number is drawn. `provenance["seed"]` has it.
    tileable : bool or {"x", "y"}
        Axes along which the output repeats without a seam.
    guide : path, array, PIL image or Exemplar, optional
        An image of the output's size that the output follows, for methods that support it. It has
        the dtype and channels of the sample, or of `sample_guide` if there is one; an opaque alpha
        is ignored.
    sample_guide : path, array, PIL image or Exemplar, optional
        An image of the sample's size that `guide` is compared with, such as an image of labels; see
        `Exemplar`.
    fit : bool
        Whether to change `size` to the nearest one that contains whole cells or rows of a
        lattice. It needs `tileable`, and has no effect if the sample has no lattice.
    best_of : int
        Number of results, 1 to 1000, made with `seed`, `seed` + 1 and so on. The one with the best
        score and fewest broken features is returned. Its provenance has all scores.
    landmarks : {"auto", "keep", "thin", "remove"}
        What to do with landmarks, small salient regions that reveal repeats: keep them, show each
        only at places far apart, or remove them. With "auto", the method `Auto` thins them if
        features are small and the output has at least 1.25 times the sample's area; below 8 times,
        only rare ones. All other methods keep them. Samples with a lattice or rows are not changed.
    threads : int, optional
        Maximum number of threads; one for each processor by default.
    progress : callable, optional
        See `weftex.progress.ProgressCallback`.
    **parameters
        Parameters of the method.

    Returns
    -------
    Synthesis
        The result; `image` has its pixels.

    Raises
    ------
    InvalidInputError
        If an argument is out of range or the sample cannot be used.
    UnsupportedError
        If the method cannot do this task, such as following a guide.
    FileError
        If the sample cannot be read.
    CancelledError
        If `progress` returned False.

    Examples
    --------
    >>> import weftex
    >>> weftex.synthesize("sample:pebbles", (240, 320), seed=7).image.shape
    (240, 320, 3)
    """
    chosen = make_method(method, parameters)
    canvas = as_canvas(size, tileable)
    if guide is not None:
        if canvas.guide is not None:
            raise InvalidInputError("the canvas has a guide; give none beside it")
        canvas = dataclasses.replace(canvas, guide=_guide(guide))
    if not is_whole(best_of, 1, _MOST_TRIES):
        raise wrong_value("best_of", best_of, f"from 1 to {_MOST_TRIES}")
    with listening(progress):
        chosen.require(canvas)
        exemplar = load_exemplar(sample)
        if sample_guide is not None:
            if canvas.guide is None:
                raise InvalidInputError("sample_guide has no effect without a guide")
            exemplar = exemplar.changed(guide=_guide(sample_guide))
        if fit:
            from weftex.tasks.auto import fitting_canvas

            canvas = fitting_canvas(canvas, exemplar, chosen)
        return synthesize_on(
            *(canvas, exemplar, chosen, chosen.fit),
            best_of=best_of,
            landmarks=landmarks,
            seed=seed_number(seed),
            threads=threads,
            progress=progress,
        )


def synthesize_on(
    canvas: Canvas,
    exemplar: Exemplar,
    method: Method,
    get_model: Callable[[Exemplar], Model],
    *,
    best_of: int = 1,
    landmarks: str = "auto",
    seed: int,
    threads: int | None = None,
    progress: ProgressCallback | None = None,
) -> Synthesis:
    """Do what `synthesize` does, with everything loaded.

    `get_model` returns the method's model of the exemplar, which it may have from before.
    """
    if exemplar.guide is None and canvas.guide is not None:
        canvas = dataclasses.replace(canvas, guide=_like(canvas.guide, exemplar))
    method.require(canvas)  # `sample` does it too, but fitting may take long
    how: dict[str, Any] = {"threads": threads, "progress": progress}
    with listening(progress):
        plain = model = None
        if landmarks not in ("auto", "keep"):
            from weftex.tasks.landmarks import plain_sample  # loads the analyses

            plain = plain_sample(exemplar, landmarks)
        elif landmarks == "auto" and best_of == 1 and _may_thin(method, canvas, exemplar):
            from weftex.tasks.landmarks import thinned

            plain = thinned(model := get_model(exemplar), canvas)
        model = method.fit(plain.exemplar) if plain else model or get_model(exemplar)
        if best_of > 1:
            made = _best_of(best_of, model, canvas, seed, how)
        else:
            if plain is not None:
                plain.inform(model)
            made = model.sample(canvas, seed=seed, **how)
        return made if plain is None else plain.finished(made, seed)


def _may_thin(method: Method, canvas: Canvas, exemplar: Exemplar) -> bool:
    """Return whether landmarks "auto" may thin: `auto` chooses, and the output is large enough."""
    times = math.prod(canvas.shape) / math.prod(exemplar.shape)
    plain = canvas.guide is None and canvas.known is None and not exemplar.pieces
    return method.slug == AUTO and plain and times >= _REPEATED


def _like(guide: NDArray[Any], exemplar: Exemplar) -> NDArray[Any]:
    """The guide without an alpha that is full everywhere, for a sample that has none."""
    if guide.ndim != 3 or guide.shape[2] not in (2, 4) or exemplar.channels != guide.shape[2] - 1:
        return guide
    full = 1 if guide.dtype.kind == "f" else np.iinfo(guide.dtype).max
    same = (guide[..., -1] == full).all()
    return guide[..., :-1].reshape(*guide.shape[:2], *exemplar.pixels.shape[2:]) if same else guide


def _guide(picture: Sample) -> NDArray[Any]:
    """Pixels; labels in whole numbers of any type as they are."""
    return picture if isinstance(picture, np.ndarray) else load_exemplar(picture).pixels


def _best_of(
    count: int, model: Model, canvas: Canvas, first: int, how: dict[str, Any]
) -> Synthesis:
    """Make several outputs and return the best one by score and broken features, or the first.

    Its provenance has its own seed, and in "best_of" all scores and a line about them.
    """
    from weftex.quality.score import MapsScorer  # loads the measures

    kept = first
    made_by: dict[int, Synthesis] = {}  # the best so far
    ratings: dict[int, Rating] = {}
    scorer = MapsScorer(model.exemplar)
    progress, threads = how["progress"], how["threads"]
    steps = Progress(progress, count, "outputs", lambda: made_by[kept].image if made_by else None)
    for number in ((first + further) % 2**64 for further in range(count)):
        made = model.sample(canvas, seed=number, threads=threads, progress=steps.within())
        ratings[number] = scorer.rate(made)
        if not made_by or ratings[number].choice < ratings[kept].choice:
            kept, made_by = number, {number: made}
        steps.advance(1)
    best = made_by[kept]
    scores = {number: one.score for number, one in ratings.items()}
    named = {str(number): score for number, score in scores.items()}
    best.provenance["best_of"] = {"scores": named, "told": _told(kept, scores)}
    return best


def _told(kept: int, scores: dict[int, float | None]) -> str:
    numbers = list(scores)
    said = f"seed {kept} of {numbers[0]} to {numbers[-1]}"
    if scores[kept] is None:
        return f"{said}: too small to be judged"
    others = sorted(score for n, score in scores.items() if n != kept and score is not None)
    said += f", by score and broken features: score {scores[kept]:.2f}"
    if len(others) < 2:
        return said + "".join(f", the other {score:.2f}" for score in others)
    return f"{said}, the others {others[0]:.2f} to {others[-1]:.2f}"
