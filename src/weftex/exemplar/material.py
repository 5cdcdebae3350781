"""Load a material: files, folders of maps, arrays and PIL images become an `Exemplar`."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from weftex.errors import FileError, InvalidInputError, shown, size_words
from weftex.exemplar.exemplar import Exemplar
from weftex.raster.arrays import as_array, is_masked
from weftex.roles import COLOR, Role, is_name_of, is_preview, role_of

if TYPE_CHECKING:
    from weftex.io.formats import StrPath
    from weftex.io.pictures import Picture

#: A path, "sample:NAME", an array, a PIL image or an Exemplar.
Sample = str | os.PathLike[str] | NDArray[Any] | Exemplar | Any

__all__ = ["Material", "load_exemplar", "read_material", "with_border"]

_MODES = ("L", "LA", "RGB", "RGBA", "I", "I;16", "I;16B", "I;16L", "I;16N", "F")  # of Pillow
_FIX = "rename them, or say which are its maps: --maps color=FILE,normal=FILE,..."


def load_exemplar(
    sample: Sample, *, files: Mapping[str, str] | None = None, **options: Any
) -> Exemplar:
    """Load a sample: a file, a folder of maps, an array or a PIL image.

    Parameters
    ----------
    sample : path, array, PIL image or Exemplar
        A folder holds the maps of one material, recognized by their file names. Its color becomes
        the pixels, and all maps take part in matching. "sample:NAME" is a sample that ships with
        weftex.
    files : mapping of str to str, optional
        The files of the folder to use, by role, such as
        ``{"color": "front.png", "normal": "n.png"}``; other files are ignored.
    **options
        Parameters of `Exemplar`, such as `mask` and `tileable`.

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
        raise InvalidInputError(f"files is {shown(files)}; it must map roles to files")
    if files is not None and not isinstance(sample, (str, os.PathLike)):
        raise InvalidInputError("files has no effect unless the sample is a folder of maps")
    if isinstance(sample, Exemplar):
        if options:
            raise InvalidInputError(f"give {next(iter(options))} to the Exemplar, not beside it")
        return sample
    if isinstance(sample, (str, os.PathLike)):
        return read_material(sample, files).exemplar(**options)
    if isinstance(sample, (list, tuple)):
        raise InvalidInputError("the sample is a list; weftex.prepare.together makes it one sample")
    image: Any = sample
    if hasattr(image, "getbands"):  # a PIL image, without importing PIL
        if image.mode in ("P", "1", "PA"):
            image = image.convert("RGBA" if "transparency" in image.info else "RGB")
        if image.mode not in _MODES:
            raise InvalidInputError(f"the image has mode {image.mode!r}; use image.convert('RGB')")
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


@dataclass(frozen=True)
class Material:
    """A picture, or the maps of one material (`folder`), as they were stored.

    `pictures` and `roles` go by the names of the maps; `notes` say what was left out, a line each.
    """

    name: str
    pictures: Mapping[str, Picture]
    roles: Mapping[str, Role]
    notes: tuple[str, ...] = ()
    folder: bool = False

    @property
    def main(self) -> str:
        """The name of the map that the material is known by: its color, else the first."""
        colors = [name for name, role in self.roles.items() if role == COLOR]
        return next(iter(colors or self.roles))

    @property
    def maps(self) -> dict[str, Exemplar]:
        """Each picture on its own, with its role."""
        return {name: self._map(name) for name in self.pictures}

    def exemplar(self, **options: Any) -> Exemplar:
        """Return the main picture with all others as its maps; options are those of `Exemplar`."""
        maps = {name: self._map(name) for name in self.pictures if name != self.main}
        return self._map(self.main, **{"maps": maps} | options)

    def _map(self, name: str, **options: Any) -> Exemplar:
        picture, role = self.pictures[name], self.roles[name]
        own: dict[str, Any] = {"alpha": picture.alpha and not role.channels, "icc": picture.icc}
        own |= {"name": self.name if name == self.main else name, "role": role}
        return Exemplar(picture.pixels, **own | options)

    def told(self) -> list[str]:
        """Return a line for each map of a set: what it was taken for, and what was left out."""
        noted = [one for one in self.pictures.values() if one.note]
        converted = [f"note: {os.path.basename(one.path)}: {one.note}" for one in noted]
        if not self.folder:
            return converted
        lines = [
            f"map: {os.path.basename(picture.path)} is {self.roles[name]}"
            + (", the main map" if name == self.main else "")
            for name, picture in self.pictures.items()
        ]
        return lines + [f"map: {note}" for note in self.notes] + converted


def read_material(path: StrPath, files: Mapping[str, str] | None = None, **limits: Any) -> Material:
    """Read a file, a folder of maps or ``sample:NAME``.

    `files` are as `load_exemplar` takes them, `limits` those of `weftex.read_image`.
    """
    from weftex.io.pictures import is_folder, locate, read_image

    place, given = locate(path)
    if not is_folder(path):
        if files is not None:
            raise InvalidInputError(f"{given} is not a folder, so it has no maps to name")
        name = os.path.basename(given)
        picture = read_image(path, **limits)
        picture.pixels.setflags(write=False)  # an Exemplar needs no copy then
        return Material(name, {name: picture}, {name: role_of_picture(given)})
    notes: list[str] = []
    if files is None:
        from weftex.io.map_files import map_files

        paths, notes = map_files(path)
        paths, roles = _by_role(paths, given, notes)
    else:
        paths, roles = _as_named(files, place, given)
    pictures = {name: read_image(paths[name], **limits) for name in paths}
    for picture in pictures.values():
        picture.pixels.setflags(write=False)
    name = os.path.basename(os.path.abspath(place))
    return Material(name, pictures, roles, tuple(notes), folder=True)


def with_border(
    material: Material, *, pad: int = 0, crop: int = 0, axes: Sequence[int] = (0, 1), flag: str = ""
) -> Material:
    """Return a material with `pad` pixels of the opposite sides around it, or without `crop`.

    Maps of another size get as much of the surface. Errors name the argument, after `flag`.
    """
    pictures, width = {}, material.pictures[material.main].pixels.shape[1]
    for name, one in material.pictures.items():
        pixels = one.pixels
        by, rest = divmod((pad or crop) * pixels.shape[1], width)
        least = min(pixels.shape[axis] for axis in axes)
        most = least if pad else (least - 1) // 2
        if rest:
            raise InvalidInputError(
                f"{pad or crop} pixels of {material.main} are {by + rest / width:g} of {name}; "
                f"give a multiple of {width // math.gcd(width, pixels.shape[1])}"
            )
        if by > most:
            raise InvalidInputError(
                f"{flag}{'pad' if pad else 'crop'} is {by}; {one.path} is "
                f"{size_words(pixels.shape)}, so it can be at most {most}"
            )
        if pad:
            sides = [(by * (axis in axes),) * 2 for axis in range(pixels.ndim)]
            pixels = np.pad(pixels, sides, "wrap")
        elif crop:
            inside = slice(by, -by)
            pixels = pixels[tuple(inside if axis in axes else slice(None) for axis in (0, 1))]
        pictures[name] = replace(one, pixels=pixels)
    return replace(material, pictures=pictures)


def has_several(path: StrPath) -> bool:
    """Return whether a path is a folder of separate pictures or sets, not the maps of one material.

    A folder with the name of a map in it is a set, so that maps never become separate by mistake.
    """
    from weftex.io.map_files import map_files
    from weftex.io.pictures import is_folder, locate

    place, given = locate(path)
    if not is_folder(path):
        return False
    try:
        paths, _ = map_files(path)
    except FileError:
        return any(os.path.isdir(os.path.join(place, name)) for name in os.listdir(place))
    try:
        _by_role(paths, given, [])
    except InvalidInputError:
        return all(role_of(stem) in (None, COLOR) for stem in paths)
    return False


def role_of_picture(path: str) -> Role:
    """The role of a single picture: normals, heights and labels are believed, else color."""
    role = role_of(os.path.splitext(os.path.basename(path))[0])
    return role if role is not None and role.kind in ("normal", "height", "labels") else COLOR


def _by_role(
    paths: Mapping[str, str], folder: str, notes: list[str]
) -> tuple[dict[str, str], dict[str, Role]]:
    """The paths, and the roles, by the roles' names; what shows the material is noted."""
    found = {stem: role_of(stem) for stem in paths}
    if len(paths) == 1:
        return dict(paths), {stem: role or COLOR for stem, role in found.items()}
    previews = [stem for stem in paths if is_preview(stem)]
    if len(previews) < len(paths):
        notes += [f"{os.path.basename(paths[k])} is ignored: it is a preview" for k in previews]
        found = {stem: role for stem, role in found.items() if stem not in previews}
    known = {stem: role for stem, role in found.items() if role is not None}
    for stem in [stem for stem in found if is_name_of(stem, [*known])]:
        if COLOR in known.values():  # ambientCG shows the material under its bare name
            notes.append(f"{os.path.basename(paths[stem])} is ignored: it is a preview")
            del found[stem]
        else:
            found[stem] = known[stem] = COLOR
    unknown = [stem for stem in found if stem not in known]
    if unknown:
        some = ", ".join(unknown[:4]) + (", ..." if len(unknown) > 4 else "")
        raise InvalidInputError(
            f"{folder} is read as one material, but some file names match no map ({some}); {_FIX}"
        )
    _refuse_twins(known, folder)
    order = sorted(known)
    return {known[k].name: paths[k] for k in order}, {known[k].name: known[k] for k in order}


def _as_named(
    files: Mapping[str, str], place: str, given: str
) -> tuple[dict[str, str], dict[str, Role]]:
    """The paths, and the roles, by the names that maps were given."""
    for name, file in files.items():
        if not isinstance(file, str) or os.path.basename(file) != file or not file:
            raise InvalidInputError(f"{file!r} is not a file in {given}")
        if not isinstance(name, str) or not name:
            raise InvalidInputError(f"files has the name {shown(name)}; it must be a role")
    if not files:
        raise InvalidInputError(f"files names no maps of {given}")
    roles = {name: role_of(name) or Role(name) for name in sorted(files)}
    _refuse_twins(roles, given)
    return {name: os.path.join(place, files[name]) for name in roles}, roles


def _refuse_twins(roles: Mapping[str, Role], folder: str) -> None:
    seen: dict[str, str] = {}
    for name, role in roles.items():
        if role.name in seen:
            raise InvalidInputError(
                f"{folder} is read as one material, but two of its files are "
                f"{role.name} ({seen[role.name]}, {name}); {_FIX}"
            )
        seen[role.name] = name
