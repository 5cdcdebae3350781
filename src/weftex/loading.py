"""Whatever shows a material, as an `Exemplar`: files, folders of maps, arrays, PIL images."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.errors import InvalidInputError, shown
from weftex.exemplar import Exemplar, as_array
from weftex.material import read_material

if TYPE_CHECKING:
    from numpy.typing import NDArray

    #: A path, "sample:NAME", an array, a PIL image or an Exemplar.
    Sample = str | os.PathLike[str] | NDArray[Any] | Exemplar | Any


def load_exemplar(
    sample: Sample, *, files: Mapping[str, str] | None = None, **options: Any
) -> Exemplar:
    """Make an Exemplar of whatever shows a material.

    Parameters
    ----------
    sample : path, array, PIL image or Exemplar
        A folder holds the maps of one material, known by their names (see `weftex.roles`); it is
        matched on the color, which gives the pixels, and on all others. "sample:NAME" is one that
        ships with weftex.
    files : mapping of str to str, optional
        Which files of the folder are its maps, and what each is, such as
        ``{"color": "front.png", "normal": "n.png"}``; others are passed over.
    **options
        For `Exemplar` (mask, tileable, alpha, maps).

    Raises
    ------
    FileError
        If a file cannot be read.
    InvalidInputError
        If the pixels cannot be used, or pictures of a folder are not named as maps.

    Examples
    --------
    >>> sorted(load_exemplar("sample:stone_wall").maps)
    ['ao', 'height', 'normal', 'roughness']
    """
    if files is not None and not isinstance(files, Mapping):
        raise InvalidInputError(f"files is {shown(files)}; it must be files by what they are")
    if files is not None and not isinstance(sample, (str, os.PathLike)):
        raise InvalidInputError("files has no effect unless the sample is a folder of maps")
    if isinstance(sample, Exemplar):
        if options:
            raise InvalidInputError(
                f"the sample is an Exemplar; give {next(iter(options))} to that"
            )
        return sample
    if isinstance(sample, (str, os.PathLike)):
        return read_material(sample, files).exemplar(**options)
    image: Any = sample
    if hasattr(image, "getbands"):  # a PIL image, without importing PIL
        if image.mode in ("P", "1", "PA"):
            image = image.convert("RGBA" if "transparency" in image.info else "RGB")
        about: dict[str, Any] = {"alpha": image.mode in ("LA", "RGBA"), "name": "image"}
        pixels = np.asarray(image)
        if pixels.dtype.kind == "i":  # Pillow's modes I and I;16
            pixels = pixels.astype(np.uint16)
        return Exemplar(pixels, **about | options)
    return Exemplar(as_array(image, "the sample"), **options)
