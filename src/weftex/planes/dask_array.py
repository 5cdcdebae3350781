"""A picture of any size as a lazy Dask array."""

from __future__ import annotations

import hashlib
import json
from typing import TYPE_CHECKING, Any

from weftex.errors import InvalidInputError, did_you_mean, missing_packages, shown
from weftex.planes.definition import Definition, define
from weftex.tasks.method_names import AUTO

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from weftex import Method

_BLOCK = 1024
_MOST_BLOCKS = 10**6  # along a side


def plane(
    sample: Any,
    size: int | tuple[int, int],
    *,
    method: str | Method = AUTO,
    seed: int | np.random.Generator | None = None,
    tileable: bool | str = False,
    block: int = _BLOCK,
    show: str | None = None,
    **parameters: Any,
) -> Any:
    """Return a picture of any size as a `dask.array.Array`, of which blocks are made when asked.

    Needs the extra ``dask``. The pixels are those that `weftex.planes.stream` writes.

    Parameters
    ----------
    sample : path, array, PIL image or Exemplar
        The material; see `weftex.load_exemplar`.
    size : int or (int, int)
        Height and width, up to 2**40 each.
    method, seed, tileable
        As for `weftex.synthesize`.
    block : int
        Side of the chunks in pixels, a power of two from 64 to 4096; it changes no pixel.
    show : str, optional
        A map of the sample by its name; its own picture by default.
    **parameters
        Of the method.

    Returns
    -------
    dask.array.Array (H, W) or (H, W, C)
        In the sample's dtype.

    Raises
    ------
    InvalidInputError
        If an argument is out of range, or there is no such map.
    UnsupportedError
        If the method does not make windows of a plane, or Dask is not installed.

    Examples
    --------
    >>> import weftex
    >>> wall = weftex.planes.plane("sample:bricks", (10**6, 10**6), seed=1, method="near-regular")
    >>> wall.shape, wall[123456:123466, 654321:654331].compute().shape
    ((1000000, 1000000, 3), (10, 10, 3))
    """
    try:
        import dask.array
        from dask.delayed import delayed
    except ImportError:
        raise missing_packages("a lazy plane needs Dask", "dask") from None
    made = define(sample, size, method, parameters, seed=seed, tileable=tileable, block=block)
    name = next(iter(made.pictures)) if show is None else show
    if name not in made.pictures:
        near = did_you_mean(name, made.pictures)
        raise InvalidInputError(f"show is '{name}'; the sample has no such map{near}")
    layout = made.layouts[name]
    if max(layout.grid(0)) > _MOST_BLOCKS:
        raise InvalidInputError(
            f"size is {shown(size)}, more than {_MOST_BLOCKS} blocks along a side; Dask lists all "
            "of them, so make the block larger"
        )
    array: Any = dask.array
    digest = hashlib.sha256(json.dumps(made.about, sort_keys=True).encode()).hexdigest()
    return array.map_blocks(
        _block,
        chunks=array.core.normalize_chunks(
            (layout.block, layout.block, *layout.axes), (layout.height, layout.width, *layout.axes)
        ),
        dtype=layout.dtype,
        meta=made.pictures[name].pixels[:0].astype(layout.dtype),
        name=f"weftex-{name}-{digest[:24]}",
        made=delayed(made, pure=True, traverse=False),
        show=name,
    )


def _block(made: Definition, show: str, block_id: tuple[int, ...] = ()) -> NDArray[Any]:
    """Make a chunk."""
    window = made.base.window((0, block_id[0], block_id[1]))
    return made.render(window, threads=1, only=show)[show]
