"""The sample of iterative refinement at its resolutions."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from weftex.errors import InvalidInputError
from weftex.exemplar import Exemplar
from weftex.search.similar import nearest_centre, similar_places
from weftex.search.stack import Layout, gaussian_stack, mask_stack
from weftex.search.window_components import window_components
from weftex.search.windows import windows_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.search.window_components import WindowComponents
    from weftex.search.windows import Windows

_REACH = 3  # pixels from the middle of a window to its side
_FINE_REACH = 1  # on the finest of several levels
_FINEST = 24  # pixels; a coarser sample has too few windows left


@dataclass(frozen=True, eq=False)
class Level:
    """The sample at one resolution.

    Every place is one of the sample at full resolution, on coarse levels too: what was put
    together so that it fits to the pixel still does when finer levels are looked at.

    Attributes
    ----------
    plain : Windows
        The level as a pyramid has it, with windows of one pixel.
    pixels : uint8 array (H', W', K)
        What is compared; see `Layout`.
    usable : uint8 array (H', W')
        1 where a window may be centred.
    places : int32 array (H', W')
        Flat index of the place of the sample that each pixel shows, -1 for none.
    settled : int32 array (H' * W')
        Where the place of each is laid itself, if it is beyond the border of a sample that tiles.
    nearest : int32 array (H, W)
        For each place of the sample where the usable one nearest to it is laid.
    reach : int
        From the middle of a window to its side.
    similar : int32 array (H' * W', k)
        The places most like each.
    cells : int32 array (H' * W')
        The sample is cut into squares as large as its scale, to see how evenly it is used.
    layout : Layout, optional
        How the pixels are put together.
    components : WindowComponents, optional
        What is compared where search is "pca".
    """

    plain: Windows
    pixels: NDArray[np.uint8]
    usable: NDArray[np.uint8]
    places: NDArray[np.int32]
    settled: NDArray[np.int32]
    nearest: NDArray[np.int32]
    reach: int
    similar: NDArray[np.int32]
    cells: NDArray[np.int32]
    layout: Layout | None = None
    components: WindowComponents | None = None

    @cached_property
    def centres(self) -> NDArray[np.int32]:
        """Flat indices into `pixels` where a window may be centred, once for each place."""
        flat = np.flatnonzero(self.usable).astype(np.int32)
        once: NDArray[np.int32] = flat[self.settled[flat] == flat]
        return once

    def at(
        self, y: NDArray[np.integer], x: NDArray[np.integer], tileable: bool = False
    ) -> NDArray[np.int32]:
        """Where the usable place nearest to one of the sample is laid."""
        height, width = self.nearest.shape
        y, x = (
            (y % height, x % width) if tileable else (y.clip(0, height - 1), x.clip(0, width - 1))
        )
        result: NDArray[np.int32] = self.nearest[y, x]
        return result


def pyramid_levels(
    exemplar: Exemplar, width: int, similar: int, narrow: bool = True
) -> list[Level]:
    """Return so many levels that a window on the coarsest is `width` pixels of the finest wide.

    Parameters
    ----------
    exemplar : Exemplar
        The sample.
    width : int
        What is wider than seven pixels is seen on coarser levels.
    similar : int
        How many places like each to find.
    narrow : bool
        Whether windows of the finest of several levels are three pixels wide. The others have
        settled what goes where; now the picture has to go on across the seams, and wider windows
        would draw these straight instead.

    Returns
    -------
    list of Level
        From the finest to the coarsest; fewer where a mask leaves no window.
    """
    reach, shape, depth = min(_REACH, width // 2), exemplar.shape, 1
    while (2 * reach + 1) << (depth - 1) < width and min(shape) >> depth >= _FINEST:
        depth += 1
    tiles = (exemplar.tileable,) * 2
    mask = np.ones(shape, bool) if exemplar.mask is None else exemplar.mask
    pictures = gaussian_stack(exemplar.matching(), depth, tiles)
    masks = mask_stack(mask, depth, tiles)
    samples = [
        Exemplar(p[0], mask=m[0], tileable=tiles[0], alpha=False, name=exemplar.name)
        for p, m in zip(pictures, masks, strict=True)
    ]
    whole = [windows_of(samples[0], (reach,) * 4, pictures[0][0])]
    for k in range(1, depth):
        try:
            whole.append(windows_of(samples[k], (reach,) * 4, pictures[k][0]))
        except InvalidInputError:  # the mask leaves no window of this level
            break
    like, coarser = np.zeros((0, 0), np.int32), None
    for windows in whole[::-1]:
        like = similar_places(windows, reach, similar, coarser)
        coarser = windows, like
    every = np.arange(shape[0] * shape[1], dtype=np.int32)
    like = whole[0].to_sample(like[whole[0].from_sample(every)])
    levels = []
    for k in range(len(whole)):
        fine = narrow and k == 0 and len(whole) > 1
        layout = Layout(shape, k, min(reach, _FINE_REACH) if fine else reach, exemplar.tileable)
        plain = windows_of(samples[k], (0,) * 4, pictures[k][0])
        levels.append(
            _level(plain, layout.lay(pictures[k]), layout.usable(masks[k]), layout, like, width)
        )
    return levels


def component_level(exemplar: Exemplar, reach: int, variance: float) -> Level:
    """Return one resolution, and windows as large as they are (section 3)."""
    windows = windows_of(exemplar, (reach,) * 4)
    every = np.arange(windows.usable.size, dtype=np.int32)
    places = windows.to_sample(every).reshape(windows.usable.shape)
    index = windows.from_sample(every[: exemplar.shape[0] * exemplar.shape[1]])
    return Level(
        windows_of(exemplar, (0,) * 4),
        windows.pixels,
        windows.usable,
        places,
        index[places.ravel()],
        _nearest(windows.usable, index, exemplar.shape),
        reach,
        np.zeros((0, 0), np.int32),
        np.zeros(0, np.int32),
        components=window_components(windows, reach, variance),
    )


def _level(
    plain: Windows,
    pixels: NDArray[np.uint8],
    usable: NDArray[np.uint8],
    layout: Layout,
    like: NDArray[np.int32],
    width: int,
) -> Level:
    """Put a level together; `like` are the places of the sample like each."""
    index, places = layout.index, layout.places
    shown = places.ravel()
    at = np.where(like < 0, np.int32(-1), index[like])
    at[usable.ravel()[at] == 0] = -1
    side = max(1, width // 2)
    y, x = np.divmod(shown.clip(0), layout.shape[1])
    return Level(
        plain,
        pixels,
        usable,
        places,
        np.where(shown < 0, np.int32(-1), index[shown]),
        _nearest(usable, index, layout.shape),
        layout.reach,
        at[shown.clip(0)],
        (y // side * (layout.shape[1] // side + 1) + x // side).astype(np.int32),
        layout,
    )


def _nearest(
    usable: NDArray[np.uint8], index: NDArray[np.int32], shape: tuple[int, int]
) -> NDArray[np.int32]:
    """See `Level.nearest`; `index` is where each place of the sample is laid."""
    may = usable.ravel()[index].reshape(shape)
    result: NDArray[np.int32] = index[nearest_centre(may)]
    return result
