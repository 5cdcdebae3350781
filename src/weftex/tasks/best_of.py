"""The best of several outputs, by the score and broken things of the color and all maps."""

from __future__ import annotations

from weftex.canvas import Canvas
from weftex.errors import InvalidInputError, shown
from weftex.exemplar import Exemplar
from weftex.method import Method
from weftex.progress import Progress, ProgressCallback
from weftex.quality.score import MapsScorer, Rating
from weftex.random import Seed, seed_number
from weftex.results.synthesis import Synthesis

_MOST_TRIES = 1000


def check_count(count: object) -> None:
    """Raise `InvalidInputError` unless it is a number of outputs."""
    whole = isinstance(count, int) and not isinstance(count, bool)
    if not (whole and 1 <= count <= _MOST_TRIES):  # type: ignore[operator]
        raise InvalidInputError(f"best_of is {shown(count)}; it must be from 1 to {_MOST_TRIES}")


def best_of(
    count: int,
    method: Method,
    exemplar: Exemplar,
    canvas: Canvas,
    *,
    seed: Seed = None,
    threads: int | None = None,
    progress: ProgressCallback | None = None,
) -> Synthesis:
    """Make several outputs and return the best one by score and broken things, or the first.

    Its provenance has its own seed, and in "best_of" all scores and a line about them.
    """
    first = seed_number(seed)
    seeds = [(first + further) % 2**64 for further in range(count)]
    kept = seeds[0]
    made_by: dict[int, Synthesis] = {}  # the best so far
    ratings: dict[int, Rating] = {}
    scorer, model = MapsScorer(exemplar), method.fit(exemplar)
    steps = Progress(progress, count, "outputs", lambda: made_by[kept].image if made_by else None)
    for number in seeds:
        made = model.sample(canvas, seed=number, threads=threads, progress=steps.within())
        ratings[number] = scorer.rate(made)
        if not made_by or ratings[number].choice < ratings[kept].choice:
            kept, made_by = number, {number: made}
        steps.advance(1)
    best = made_by[kept]
    scores = {number: one.score for number, one in ratings.items()}
    about = {"scores": {str(number): score for number, score in scores.items()}}
    best.provenance["best_of"] = {**about, "told": _told(kept, scores)}
    return best


def _told(kept: int, scores: dict[int, float | None]) -> str:
    numbers = list(scores)
    said = f"seed {kept} of {numbers[0]} to {numbers[-1]}"
    if scores[kept] is None:
        return f"{said}: too small to be judged"
    others = sorted(score for n, score in scores.items() if n != kept and score is not None)
    said += f", by score and broken things: score {scores[kept]:.2f}"
    if len(others) < 2:
        return said + "".join(f", the other {score:.2f}" for score in others)
    return f"{said}, the others {others[0]:.2f} to {others[-1]:.2f}"
