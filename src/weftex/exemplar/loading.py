"""Whatever shows a material, as an `Exemplar`: files, folders of maps, arrays, PIL images."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.errors import InvalidInputError, shown
from weftex.exemplar.exemplar import Exemplar
from weftex.exemplar.material import read_material
from weftex.raster.arrays import as_array, is_masked

if TYPE_CHECKING:
    from numpy.typing import NDArray

    #: A path, "sample:NAME", an array, a PIL image or an Exemplar.
    Sample = str | os.PathLike[str] | NDArray[Any] | Exemplar | Any

_MODES = ("L", "LA", "RGB", "RGBA", "I", "I;16", "I;16B", "I;16L", "I;16N", "F")  # of Pillow


def load_exemplar(
    sample: Sample, *, files: Mapping[str, str] | None = None, **options: Any
) -> Exemplar:
    """Load a sample: a file, a folder of maps, an array or a PIL image.

    Parameters
    ----------
    sample : path, array, PIL image or Exemplar
        A folder holds the maps of one material, recognized by their names (see `weftex.roles`). Its
        color is the pixels, and all maps take part in matching. "sample:NAME" is a sample that
        ships with weftex.
    files : mapping of str to str, optional
        Which files of the folder are its maps, and what each is, such as
        ``{"color": "front.png", "normal": "n.png"}``; others are ignored.
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
        if image.mode not in _MODES:
            raise InvalidInputError(
                f"the image has mode {image.mode!r}; convert it first: image.convert('RGB')"
            )
        about: dict[str, Any] = {"alpha": image.mode in ("LA", "RGBA"), "name": "image"}
        pixels = np.asarray(image)
        if pixels.dtype.kind == "i":  # Pillow's mode I
            if pixels.min() < 0 or pixels.max() > 65535:
                raise InvalidInputError(
                    f"the image has values from {pixels.min()} to {pixels.max()}; they must be "
                    "from 0 to 65535"
                )
            pixels = pixels.astype(np.uint16)
        return Exemplar(pixels, **about | options)
    return Exemplar(image if is_masked(image) else as_array(image, "the sample"), **options)
