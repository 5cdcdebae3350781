"""Seam at the wrap: whether the border of a tileable result shows when it is repeated."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from weftex.quality.seams import Seams
    from weftex.quality.view import View


def wrap_seam(model: Seams, result: View, wrap: tuple[bool, bool]) -> float | None:
    """Say how much of the border of a tileable result looks like a seam.

    *Definition.* The share of the border at which the step across it is more surprising (see
    `weftex.quality.seams`) than 99 % of the steps inside the result; of both axes the worse.

    *Unit.* Share. *Good.* Low: about 0.01 where nothing shows, 0.5 to 1 where a picture does not
    tile. *Blind to* what `seams` is blind to, and to tiles that are easily told apart because
    something striking in them repeats.

    Parameters
    ----------
    model : Seams
        Of the sample.
    result : View
        From `views`.
    wrap : (bool, bool)
        Whether the vertical and the horizontal axis are to repeat.

    Returns
    -------
    float or None
        None where no axis is, and where `seams` is None.
    """
    if not any(wrap) or not model.able or not model.fits(result):
        return None
    return max(model.border(result, axis) for axis in (0, 1) if wrap[axis])
