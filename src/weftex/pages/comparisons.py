"""Every method on one sample, side by side: pictures, sources, figures, times."""

from __future__ import annotations

from dataclasses import replace
from time import perf_counter
from typing import TYPE_CHECKING, Any

from weftex import METHODS, InvalidInputError, UnsupportedError, assess, load_exemplar
from weftex.canvas import as_canvas
from weftex.errors import shown
from weftex.pages.comparison_page import Comparison, Entry
from weftex.progress import Progress
from weftex.random import seed_number
from weftex.tasks.auto import Auto, AutoModel
from weftex.tasks.method_names import AUTO, make_method

if TYPE_CHECKING:
    from collections.abc import Sequence

    import numpy as np

    from weftex.progress import ProgressCallback

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

    A method that cannot do it says why in its place.

    Parameters
    ----------
    sample : path, array, PIL image or Exemplar
        The material; see `weftex.load_exemplar`.
    size : int or (int, int), optional
        Height and width of the outputs; twice the sample by default, at most 512.
    methods : sequence of str, optional
        Names in `weftex.METHODS`, or "auto"; all methods by default.
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
    (['quilting', 'best-tile'], 'graphcut')
    """
    if methods is not None and not isinstance(methods, (list, tuple)):
        raise InvalidInputError(f"methods is {shown(methods)}; it must be a list of names")
    names = list(METHODS) if methods is None else list(methods)
    made = {name: make_method(name, {}) for name in names}  # raises for an unknown one
    if not names or len(made) < len(names):
        raise InvalidInputError(f"methods is {', '.join(names)!r}; name each once, at least one")
    exemplar = load_exemplar(sample)
    if size is None:
        size = (min(_USUAL, 2 * exemplar.shape[0]), min(_USUAL, 2 * exemplar.shape[1]))
    canvas, number = as_canvas(size, tileable), seed_number(seed)
    done: list[Entry] = []
    count = Progress(progress, len(names), "methods", lambda: done and _last(done))
    options: dict[str, Any] = {"seed": number, "threads": threads, "progress": count.within()}
    for name, method in made.items():
        start = perf_counter()
        try:
            method.require(canvas)
            result = method.fit(exemplar).sample(canvas, **options)
            result.image  # rendering is part of the work  # noqa: B018
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


def _last(done: list[Entry]) -> Any:
    """The last picture there is."""
    made = [entry.result for entry in done if entry.result is not None]
    return made[-1].image if made else None
