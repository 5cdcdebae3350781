"""The studio's views in a notebook, from the page's own modules."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from weftex.errors import InvalidInputError, missing_packages, shown

if TYPE_CHECKING:
    from weftex import Synthesis

LOWEST, HIGHEST = 160, 4000  # pixels of the screen


def view(thing: Synthesis | Any, *, height: int = 480) -> Any:
    """Show a result or a sample in a notebook, to pan and zoom to single pixels.

    The views are those of `weftex studio`: repeated, beside the repeated sample, all maps side by
    side, under a light that follows the pointer, with the coordinates in the sample, the patches
    and the seams drawn over it. Needs the extra ``notebook``, and a running kernel.

    Parameters
    ----------
    thing : Synthesis, or what `weftex.load_exemplar` takes
    height : int
        Height on the screen, from 160 to 4000 pixels.

    Returns
    -------
    anywidget.AnyWidget
        That shows itself as the last line of a cell.

    Raises
    ------
    UnsupportedError
        Without anywidget.
    InvalidInputError
        If there is no picture, or the height is out of its range.

    Examples
    --------
    >>> import weftex
    >>> made = weftex.synthesize("sample:bricks", 128, method="quilting", seed=1)
    >>> weftex.studio.view(made).height
    480
    """
    if type(height) is not int or not LOWEST <= height <= HIGHEST:
        raise InvalidInputError(f"height is {shown(height)}; it must be from {LOWEST} to {HIGHEST}")
    try:
        from weftex.studio.widget import View
    except ModuleNotFoundError as error:
        if (error.name or "").split(".")[0] != "anywidget":
            raise
        raise missing_packages("a view in a notebook needs anywidget", "notebook") from None
    from weftex import Synthesis, load_exemplar

    if isinstance(thing, Synthesis):
        return View(thing.sample, thing, height=height)
    return View(load_exemplar(thing), None, height=height)
