"""The folders of ComfyUI that sets are loaded from and saved to."""

from __future__ import annotations

import hashlib
import os
import shutil
from pathlib import Path

import folder_paths

from weftex.errors import FileError, InvalidInputError
from weftex.exemplar.material import Material
from weftex.io.formats import READABLE, suffix_of
from weftex.io.packing import write_preset
from weftex.io.pictures import sample_names

_SAMPLE = "sample:"


def sets() -> list[str]:
    """Return the folders with images below ComfyUI's input folder, and weftex's own samples."""
    root = folder_paths.get_input_directory()
    found = []
    for folder, _, files in os.walk(root):
        if folder != root and any(suffix_of(file) in READABLE for file in files):
            found.append(os.path.relpath(folder, root).replace(os.sep, "/"))
    return sorted(found) + [_SAMPLE + name for name in sample_names()]


def path_of(name: str) -> str:
    """Return the path of a set; refuses everything outside ComfyUI's input folder."""
    if name.startswith(_SAMPLE):
        return name
    root = os.path.realpath(folder_paths.get_input_directory())
    path = os.path.realpath(os.path.join(root, name))
    if path == root or os.path.commonpath([root, path]) != root:
        raise InvalidInputError(f"{name} is not in ComfyUI's input folder")
    return path


def state_of(name: str) -> str:
    """Return a text that changes with the files of a set."""
    if name.startswith(_SAMPLE):
        return name
    files = sorted(Path(path_of(name)).glob("*"))
    about = [(one.name, one.stat().st_size, one.stat().st_mtime_ns) for one in files]
    return hashlib.sha256(repr(about).encode()).hexdigest()


def save(material: Material, prefix: str, preset: str) -> list[dict[str, str]]:
    """Write a set to a new folder below ComfyUI's output folder; return its files for the page.

    The folder appears when all files are written.
    """
    root = folder_paths.get_output_directory()
    height, width = material.pictures[material.main].pixels.shape[:2]
    folder, stem, number, below, _ = folder_paths.get_save_image_path(prefix, root, width, height)
    name = f"{stem}_{number:05}_"
    unfinished = os.path.join(folder, f".{name}")
    os.mkdir(unfinished)
    try:
        files, _ = write_preset(
            material.pictures, unfinished, preset, roles=material.roles, name=stem
        )
        target = os.path.join(folder, name)
        if os.path.lexists(target):
            raise FileError(f"{target} exists already; try again")
        os.rename(unfinished, target)
    finally:
        shutil.rmtree(unfinished, ignore_errors=True)
    subfolder = os.path.join(below, name)
    return [{"filename": file, "subfolder": subfolder, "type": "output"} for file in files]
