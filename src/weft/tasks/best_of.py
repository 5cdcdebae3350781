"""The best of several outputs, by the measures of `weft.quality`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from weft.errors import InvalidInputError
from weft.progress import Progress
from weft.quality.assess import assess
from weft.random import seed_number

if TYPE_CHECKING:
    from weft.canvas import Canvas
    from weft.method import Model
    from weft.progress import ProgressCallback
    from weft.random import Seed
    from weft.synthesis import Synthesis

_MOST = 1000
_JUDGED = 1024  # pixels a side of the middle by which a larger output is judged


def check_count(count: int) -> None:
    """Raise `InvalidInputError` unless so many outputs can be made."""
    if type(count) is not int or not 1 <= count <= _MOST:
        raise InvalidInputError(f"best_of is {count!r}; it must be an integer from 1 to {_MOST}")


def best_of(
    model: Model,
    canvas: Canvas,
    count: int,
    *,
    seed: Seed = None,
    threads: int | None = None,
    progress: ProgressCallback | None = None,
) -> Synthesis:
    """Make several outputs and keep the one with the best score; of equal ones the first.

    Parameters
    ----------
    model : Model
        The fitted method.
    canvas : Canvas
        What to make.
    count : int
        So many, with `seed` and the seeds after it.
    seed, threads, progress
        As for `weft.synthesize`; progress counts outputs, and is also asked within each.

    Returns
    -------
    Synthesis
        Its provenance has its own seed, and under "best_of" the scores of all and `told`, a line.

    Examples
    --------
    >>> import weft
    >>> from weft.canvas import Canvas
    >>> model = weft.Quilting().fit(weft.load_exemplar("sample:weave"))
    >>> best = best_of(model, Canvas(96, 96), 2, seed=7)
    >>> again = model.sample(96, seed=best.provenance["seed"])
    >>> bool((again.image == best.image).all()), sorted(best.provenance["best_of"]["scores"])
    (True, ['7', '8'])
    """
    check_count(count)
    first = seed_number(seed)
    seeds = [(first + k) % 2**64 for k in range(count)]
    best: Synthesis | None = None
    scores: dict[int, float | None] = {}
    steps = Progress(progress, count, "outputs", lambda: None if best is None else best.image)
    for number in seeds:
        made = model.sample(canvas, seed=number, threads=threads, progress=steps.within())
        scores[number] = _score(made)
        if best is None or _key(scores[number]) < _key(scores[best.provenance["seed"]]):
            best = made
        steps.advance(1)
    assert best is not None
    kept = best.provenance["seed"]
    best.provenance["best_of"] = {
        "scores": {str(number): score for number, score in scores.items()},
        "told": _told(kept, scores),
    }
    return best


def _score(made: Synthesis) -> float | None:
    assert made.exemplar is not None
    if max(made.shape) <= _JUDGED:
        return assess(made.exemplar, made).score
    middle = tuple(
        slice((side - min(side, _JUDGED)) // 2, (side + min(side, _JUDGED)) // 2)
        for side in made.shape
    )
    return assess(made.exemplar, made.image[middle], made.source[middle]).score


def _key(score: float | None) -> float:
    return float("inf") if score is None else score


def _told(kept: int, scores: dict[int, float | None]) -> str:
    seeds = list(scores)
    said = f"seed {kept} of {seeds[0]} to {seeds[-1]}: "
    if scores[kept] is None:
        return f"{said}too small to be judged"
    others = sorted(_key(score) for number, score in scores.items() if number != kept)
    said += f"score {scores[kept]:.2f}"
    if len(others) < 2:
        return said + "".join(f", the other {score:.2f}" for score in others)
    return f"{said}, the others {others[0]:.2f} to {others[-1]:.2f}"
