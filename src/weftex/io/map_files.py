"""The files of a set of maps in a folder."""

from __future__ import annotations

import os

from weftex.io.formats import READABLE, StrPath, bits_of, file_error, show, suffix_of
from weftex.io.pictures import locate

#: Where libraries keep the maps beside a scene file.
_INNER = "textures"
#: Pictures that weftex does not read, so that nobody misses one without a word.
_UNREAD = (".psd", ".dds", ".jp2", ".ktx", ".ktx2", ".sgi", ".pic", ".tx")
_LOSSY = (".jpg", ".jpeg")


def map_files(folder: StrPath) -> tuple[dict[str, str], list[str]]:
    """Paths of a folder's pictures by stem, and notes on what was left out.

    Of two with one stem the deeper wins, then the one that is not a JPEG. A folder without pictures
    may have them in `textures`. Raises `FileError` if there are none, or two alike.
    """
    name, given = locate(folder)
    paths, notes = _listed(name, given)
    inner = os.path.join(name, _INNER)
    if not paths and os.path.isdir(inner):
        paths, notes = _listed(inner, given)
        notes.insert(0, f"maps are those in {show(os.path.join(given, _INNER))}")
    if not paths:
        raise file_error(given, f"has no images ({', '.join(READABLE)})")
    return paths, notes


def _listed(name: str, given: str) -> tuple[dict[str, str], list[str]]:
    try:
        found = sorted(os.listdir(name))
    except (OSError, ValueError) as error:
        raise file_error(given, "cannot read the folder", error) from None
    paths: dict[str, str] = {}
    notes = []
    for file in found:
        stem, full = os.path.splitext(file)[0], os.path.join(name, file)
        if file.startswith(".") or os.path.isdir(full):
            continue
        if suffix_of(file) in _UNREAD:
            notes.append(f"{show(file)} is ignored: weftex does not read {suffix_of(file)}")
        if suffix_of(file) not in READABLE:
            continue
        if stem in paths:
            pair = sorted((full, paths[stem]), key=_depth)
            if _depth(pair[0]) == _depth(pair[1]):
                raise file_error(given, f"has two images named '{show(stem)}'; keep one")
            left, kept = (show(os.path.basename(path)) for path in pair)
            why = "has more bits" if _depth(pair[0])[0] < _depth(pair[1])[0] else "is not a JPEG"
            notes.append(f"{left} is ignored: {kept} {why}")
            full = pair[1]
        paths[stem] = full
    return paths, notes


def _depth(path: str) -> tuple[int, bool]:
    return bits_of(path), suffix_of(path) not in _LOSSY
