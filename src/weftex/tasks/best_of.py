"""The best of several outputs, by the score of the color and all maps."""

from __future__ import annotations

from typing import TYPE_CHECKING

from weftex.errors import InvalidInputError, shown
from weftex.progress import Progress
from weftex.quality.score import MapsScorer
from weftex.random import seed_number
from weftex.tasks.method_names import AUTO, make_method

if TYPE_CHECKING:
    from collections.abc import Sequence

    from weftex.canvas import Canvas
    from weftex.exemplar import Exemplar
    from weftex.method import Method
    from weftex.progress import ProgressCallback
    from weftex.random import Seed
    from weftex.results.synthesis import Synthesis

_MOST_TRIES = 1000


def tries(method: Method, count: int | Sequence[str | Method]) -> list[tuple[Method, int]]:
    """Return the methods to try, each with what is added to the first seed.

    `count` is a number of seeds, or a list of methods that are tried with one seed.
    """
    if isinstance(count, int) and not isinstance(count, bool):
        if not 1 <= count <= _MOST_TRIES:
            raise InvalidInputError(
                f"best_of is {shown(count)}; it must be from 1 to {_MOST_TRIES}"
            )
        return [(method, k) for k in range(count)]
    if not isinstance(count, (list, tuple)) or not count:
        raise InvalidInputError(
            f"best_of is {shown(count)}; it must be from 1 to {_MOST_TRIES}, or a list of methods"
        )
    if method.slug != AUTO:
        raise InvalidInputError(f"best_of lists the methods to try; add {method.slug} to that list")
    return [(make_method(one, {}), 0) for one in count]


def best_of(
    tried: Sequence[tuple[Method, int]],
    exemplar: Exemplar,
    canvas: Canvas,
    *,
    seed: Seed = None,
    threads: int | None = None,
    progress: ProgressCallback | None = None,
) -> Synthesis:
    """Make several outputs and return the one with the best score, the first of equal ones.

    Its provenance has its own method and seed, and in "best_of" all scores and a line about them.
    """
    first = seed_number(seed)
    seeds = [(first + further) % 2**64 for _, further in tried]
    methods = [method for method, _ in tried]
    several = len(set(seeds)) == 1 and len(tried) > 1
    names = _distinct([method.slug for method in methods]) if several else list(map(str, seeds))
    kept = names[0]
    made_by: dict[str, Synthesis] = {}  # the best so far
    scores: dict[str, float | None] = {}
    fitted: Method | None = None
    scorer = MapsScorer(exemplar)
    steps = Progress(
        progress, len(tried), "outputs", lambda: made_by[kept].image if made_by else None
    )
    for name, method, number in zip(names, methods, seeds, strict=True):
        if method is not fitted:
            model, fitted = method.fit(exemplar), method
        made = model.sample(canvas, seed=number, threads=threads, progress=steps.within())
        scores[name] = scorer.score(made)
        if not made_by or _key(scores[name]) < _key(scores[kept]):
            kept, made_by = name, {name: made}
        steps.advance(1)
    best = made_by[kept]
    told = _told(kept, scores, "" if several else "seed ")
    best.provenance["best_of"] = {"scores": scores, "told": told}
    return best


def _distinct(names: list[str]) -> list[str]:
    """Return distinct names: the same method with other parameters gets a number."""
    count = [names[:k].count(name) for k, name in enumerate(names)]
    return [f"{name} {k + 1}" if k else name for name, k in zip(names, count, strict=True)]


def _key(score: float | None) -> float:
    return float("inf") if score is None else score


def _told(kept: str, scores: dict[str, float | None], what: str) -> str:
    names = list(scores)
    among = f"{names[0]} to {names[-1]}" if what else ", ".join(names)
    said = f"{what}{kept} of {among}: "
    if scores[kept] is None:
        return f"{said}too small to be judged"
    others = sorted(_key(score) for name, score in scores.items() if name != kept)
    said += f"score {scores[kept]:.2f}"
    if len(others) < 2:
        return said + "".join(f", the other {score:.2f}" for score in others)
    return f"{said}, the others {others[0]:.2f} to {others[-1]:.2f}"
