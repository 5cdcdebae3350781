"""A material as its files have it: pictures with roles."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from weftex.errors import InvalidInputError, shown
from weftex.exemplar.exemplar import Exemplar
from weftex.roles import COLOR, Role, is_name_of, is_preview, role_of

if TYPE_CHECKING:
    from collections.abc import Mapping

    from weftex.io.pictures import Picture, StrPath

__all__ = ["Material", "read_material"]

_FIX = "rename them, or say which are its maps: --maps color=FILE,normal=FILE,..."


@dataclass(frozen=True)
class Material:
    """A picture, or the maps of one material, as they were stored.

    Attributes
    ----------
    name : str
        That of the folder, or of the file.
    pictures : dict of str to Picture
        By the names of the maps, which are those of their roles unless others were given.
    roles : dict of str to Role
        What each of them shows.
    notes : tuple of str
        What was left out, a line each.
    folder : bool
        Whether it is a set of maps.
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
        return {
            name: Exemplar(
                picture.pixels,
                alpha=picture.alpha and not self.roles[name].channels,
                icc=picture.icc,
                name=self.name if name == self.main else name,
                role=self.roles[name],
            )
            for name, picture in self.pictures.items()
        }

    def exemplar(self, **options: Any) -> Exemplar:
        """Return the main picture with all others as its maps; options are those of `Exemplar`."""
        maps = self.maps
        return maps.pop(self.main).changed(**{"maps": maps} | options)

    def told(self) -> list[str]:
        """Return a line for each map of a set: what it was taken for, and what was left out."""
        if not self.folder:
            return []
        lines = [
            f"map: {os.path.basename(picture.path)} is {self.roles[name]}"
            + (", the picture" if name == self.main else "")
            for name, picture in self.pictures.items()
        ]
        return lines + [f"map: {note}" for note in self.notes]


def read_material(path: StrPath, files: Mapping[str, str] | None = None, **limits: Any) -> Material:
    """Read a picture, or the maps of a folder, which are known by their names.

    Parameters
    ----------
    path : path
        A file, a folder or ``sample:NAME``.
    files : mapping of str to str, optional
        Which files of the folder are its maps, and what each is, such as
        ``{"color": "front.png", "normal": "n.png"}``; others are passed over.
    **limits
        Those of `weftex.read_image`.

    Raises
    ------
    FileError
        If a file cannot be read.
    InvalidInputError
        If pictures of a folder are not named as maps, or two of them are the same.

    Examples
    --------
    >>> [str(role) for role in read_material("sample:stone_wall").roles.values()]
    ['color', 'ao', 'height', 'normal (y up or down is not said)', 'roughness']
    """
    from weftex.io.pictures import is_folder, locate, read_image

    place, given = locate(path)
    if not is_folder(path):
        if files is not None:
            raise InvalidInputError(f"{given} is no folder, so it has no maps to name")
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


def role_of_picture(path: str) -> Role:
    """The role of a single picture: only normal and height are believed, else color."""
    role = role_of(os.path.splitext(os.path.basename(path))[0])
    return role if role is not None and role.kind in ("normal", "height") else COLOR


def _by_role(
    paths: Mapping[str, str], folder: str, notes: list[str]
) -> tuple[dict[str, str], dict[str, Role]]:
    """The paths, and the roles, by the roles' names; what shows the material is noted."""
    found = {stem: role_of(stem) for stem in paths}
    if len(paths) == 1:
        return dict(paths), {stem: role or COLOR for stem, role in found.items()}
    previews = [stem for stem in paths if is_preview(stem)]
    if len(previews) < len(paths):
        notes += [f"{os.path.basename(paths[stem])} is left out: a preview" for stem in previews]
        found = {stem: role for stem, role in found.items() if stem not in previews}
    known = {stem: role for stem, role in found.items() if role is not None}
    for stem in [stem for stem in found if is_name_of(stem, [*known])]:
        if COLOR in known.values():  # ambientCG shows the material under its bare name
            notes.append(f"{os.path.basename(paths[stem])} is left out: a preview")
            del found[stem]
        else:
            found[stem] = known[stem] = COLOR
    unknown = [stem for stem in found if stem not in known]
    if unknown:
        raise InvalidInputError(
            f"{folder} has pictures whose names are of no map ({_some(unknown)}), and a folder "
            f"is taken for the maps of one material; {_FIX}"
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
            raise InvalidInputError(f"{file!r} is no name of a file in {given}")
        if not isinstance(name, str) or not name:
            raise InvalidInputError(f"files has the name {shown(name)}; it must say what a map is")
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
                f"{folder} has two pictures that are named {role.name} ({seen[role.name]}, {name})"
                f", and a folder is taken for the maps of one material; {_FIX}"
            )
        seen[role.name] = name


def _some(names: list[str]) -> str:
    return ", ".join(names[:4]) + (", ..." if len(names) > 4 else "")
