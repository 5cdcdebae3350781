"""Whatever shows a material, as an `Exemplar`: files, folders of maps, arrays, PIL images."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.errors import InvalidInputError, shown
from weftex.exemplar import Exemplar, as_array
from weftex.io.map_names import COLOR, roles_of

if TYPE_CHECKING:
    from collections.abc import Collection

    from numpy.typing import NDArray

    from weftex.io.pictures import Picture

    #: A path, "sample:NAME", an array, a PIL image or an Exemplar.
    Sample = str | os.PathLike[str] | NDArray[Any] | Exemplar | Any


def load_exemplar(
    sample: Sample, *, files: Mapping[str, str] | None = None, **options: Any
) -> Exemplar:
    """Make an Exemplar of whatever shows a material.

    Parameters
    ----------
    sample : path, array, PIL image or Exemplar
        A folder holds the maps of one material, known by their names (see
        `weftex.io.map_names.ROLES`); it is matched on the color, which gives the pixels, and on
        all others. "sample:NAME" is one that ships with weftex.
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
        return exemplar_of_maps(read_sample(sample, files), os.fsdecode(sample), files, **options)
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


def read_sample(
    path: str | os.PathLike[str], files: Mapping[str, str] | None = None, **limits: Any
) -> dict[str, Picture]:
    """Read a picture, or the pictures of a folder, by name; with `files` by what they are.

    The limits are those of `weftex.read_image`.
    """
    from weftex.io.pictures import is_folder, map_files, read_image, read_maps

    if is_folder(path):
        for file in () if files is None else files.values():
            if not isinstance(file, str) or os.path.basename(file) != file:
                raise InvalidInputError(f"{file!r} is no name of a file in {os.fsdecode(path)}")
        if files is None:
            roles(map_files(path), os.fsdecode(path))  # before memory is taken for all of them
        return read_maps(path, files=files, **limits)
    if files is not None:
        raise InvalidInputError(f"{os.fsdecode(path)} is no folder, so it has no maps to name")
    return {os.path.basename(os.fsdecode(path)): read_image(path, **limits)}


def exemplar_of_maps(
    pictures: Mapping[str, Picture],
    folder: str = "the folder",
    files: Mapping[str, str] | None = None,
    **options: Any,
) -> Exemplar:
    """Make an Exemplar of one picture, or of the maps of one material.

    Parameters
    ----------
    pictures : mapping of str to Picture
        From `read_sample`, by name; the color becomes the pixels, or the first if there is none.
    folder : str
        What to call it in messages.
    files : mapping, optional
        As given to `read_sample`: the names are what the maps are.
    **options
        For `Exemplar`.

    Raises
    ------
    InvalidInputError
        If there are several pictures, and their names do not say which maps they are.
    """
    name = main_picture(roles(pictures, folder, files))
    maps = {key: picture.pixels for key, picture in pictures.items() if key != name}
    main = pictures[name]
    about: dict[str, Any] = {"alpha": main.alpha, "icc": main.icc, "name": name, "maps": maps}
    return Exemplar(main.pixels, **about | options)


def roles(
    pictures: Collection[str], folder: str, files: Mapping[str, str] | None = None
) -> dict[str, str]:
    """What each picture shows, by its name."""
    if len(pictures) == 1 or files is not None:
        return {name: name for name in sorted(pictures)}
    return roles_of(sorted(pictures), folder)


def main_picture(roles: Mapping[str, str]) -> str:
    """The name of the picture that a material is known by: its color, else the first."""
    return next((name for name, role in roles.items() if role == COLOR), next(iter(roles)))
