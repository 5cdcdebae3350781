"""How a method makes a pixel, step by step, as pictures of its intermediate values."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from weftex.canvas import as_canvas
from weftex.errors import InvalidInputError, UnsupportedError, shown
from weftex.exemplar import load_exemplar
from weftex.explanation.lattices import BestTileRecorder, NearRegularRecorder
from weftex.explanation.patches import GraphCutRecorder, PatchRecorder
from weftex.explanation.pixels import (
    AshikhminRecorder,
    EfrosLeungRecorder,
    ExactMatchingRecorder,
    RefinementRecorder,
    WeiLevoyRecorder,
)
from weftex.explanation.stages import Explanation, Recorder, Stage
from weftex.naming import make_method
from weftex.notes import Listener, listening

if TYPE_CHECKING:
    from weftex.exemplar import Sample
    from weftex.method import Method
    from weftex.random import Seed

#: Who listens to each method.
RECORDERS: dict[str, type[Recorder]] = {
    "patch-sampling": PatchRecorder,
    "quilting": PatchRecorder,
    "graphcut": GraphCutRecorder,
    "efros-leung": EfrosLeungRecorder,
    "wei-levoy": WeiLevoyRecorder,
    "ashikhmin": AshikhminRecorder,
    "exact-matching": ExactMatchingRecorder,
    "refinement": RefinementRecorder,
    "near-regular": NearRegularRecorder,
    "best-tile": BestTileRecorder,
}


def explain(
    sample: Sample,
    size: int | tuple[int, int],
    *,
    method: str | Method = "patch-sampling",
    seed: Seed = None,
    at: tuple[int, int] | None = None,
    tileable: bool | str = False,
    **parameters: Any,
) -> Explanation:
    """Show how a method makes one pixel of an output.

    The method runs as usual and makes the same image; its intermediate values are recorded:
    neighborhoods, error surfaces and candidates, cuts, the order of growth, the levels of a
    pyramid, the path down a tree, the lattice.

    Parameters
    ----------
    sample : path, array, PIL image or Exemplar
        The material; see `weftex.load_exemplar`. Small ones show more.
    size : int or (int, int)
        Height and width of the output.
    method : str or Method
        A name in `weftex.METHODS`, or a method with its parameters.
    seed : int, numpy Generator or None
        As for `weftex.synthesize`.
    at : (int, int), optional
        Row and column of the pixel; by default one past the middle.
    tileable : bool or {"x", "y"}
        Axes that wrap around without a seam.
    **parameters
        Of the method, if that is a name.

    Returns
    -------
    Explanation
        The stages, with `result`; in a notebook it shows itself.

    Raises
    ------
    InvalidInputError
        If `at` is not in the output.
    UnsupportedError
        If the method records no steps.

    Examples
    --------
    >>> shown = explain("sample:pebbles", 64, method="quilting", patch_size=24, seed=7)
    >>> [stage.title for stage in shown]
    ['canvas', 'boundary zone', 'error surface', 'candidates', 'patch', 'canvas after']
    >>> shown["error surface"].array.shape
    (192, 192)
    """
    chosen = make_method(method, parameters)
    if chosen.slug not in RECORDERS:
        raise UnsupportedError(
            f"{chosen.slug} does not say how it works; these do: {', '.join(RECORDERS)}"
        )
    exemplar, canvas = load_exemplar(sample), as_canvas(size, tileable)
    pixel = _pixel_of(at, canvas.shape)
    recorder = RECORDERS[chosen.slug](exemplar, pixel)
    with listening(Listener(pixel, recorder.record)):
        result = chosen.fit(exemplar).sample(canvas, seed=seed, threads=1)
    return Explanation(result, pixel, recorder.stages())


def _pixel_of(at: tuple[int, int] | None, shape: tuple[int, int]) -> tuple[int, int]:
    if at is None:
        return shape[0] * 5 // 8, shape[1] * 5 // 8
    try:
        y, x = (int(n) for n in at)
    except (TypeError, ValueError):
        raise InvalidInputError(f"at is {shown(at)}; it must be a row and a column") from None
    if not (0 <= y < shape[0] and 0 <= x < shape[1]):
        raise InvalidInputError(f"at is {shown(at)}; the output is {shape[1]}x{shape[0]}")
    return y, x


__all__ = ["Explanation", "Stage", "explain"]
