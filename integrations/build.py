"""Package an integration as the file that its host program installs.

    python integrations/build.py blender|comfyui|gimp|krita [--wheels FOLDER] [--output FOLDER]

For Blender and ComfyUI, wheels of weftex are taken from the folder, for each system that it has one
for; without a folder one is built for this machine. The packages that weftex needs in Blender
besides NumPy, which are pure Python, come from the package index.
The plug-ins of GIMP and Krita call the command weftex: they contain no wheels, but the options that
weftex declares.
"""

from __future__ import annotations

import argparse
import json
import shutil
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
_PURE = ["threadpoolctl>=3.1", "tqdm>=4.66"]
#: Blender's names of systems, by a part of the names of wheels.
_SYSTEMS = {
    "linux_x86_64": "linux-x64",
    "x86_64.whl": "linux-x64",
    "macosx": "macos-arm64",
    "win_amd64": "windows-x64",
}
#: The options that dialogs of GIMP and Krita show, beside the method and the seed.
_DIALOGS = {
    "synth": ("size", "tileable", "landmarks"),
    "tile": ("axes", "border"),
    "fill": ("match_tone",),  # an overlap would change unselected pixels
    "fuse": ("boundary", "belt_width", "tileable"),
}
_METHOD = "synthesis method; weftex chooses one for the sample unless you do"


def blender(wheels: Path | None, output: Path) -> Path:
    """Write the extension as a ZIP file with its wheels, and return its path."""
    source = HERE / "blender" / "weftex_blender"
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary) / source.name
        shutil.copytree(source, folder, ignore=shutil.ignore_patterns("__pycache__"))
        kept = folder / "wheels"
        own = _add_wheels(wheels, kept)
        _pip("download", "--no-deps", "--only-binary=:all:", "--dest", str(kept), *_PURE)
        systems = sorted({name for part, name in _SYSTEMS.items() for one in own if part in one})
        manifest = folder / "blender_manifest.toml"
        head, permissions = manifest.read_text("utf-8").split("\n[permissions]")
        listed = ", ".join(f'"./wheels/{one.name}"' for one in sorted(kept.iterdir()))
        named = ", ".join(f'"{name}"' for name in systems)
        lines = f"platforms = [{named}]\nwheels = [{listed}]\n"
        manifest.write_text(f"{head}{lines}\n[permissions]{permissions}", "utf-8")
        shutil.copy(HERE.parent / "LICENSE", folder)
        return _pack(folder, folder, output / f"{source.name}.zip")


def comfyui(wheels: Path | None, output: Path) -> Path:
    """Write the folder of nodes as a ZIP file that is unpacked in `custom_nodes`."""
    source = HERE / "comfyui" / "weftex_comfyui"
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary) / source.name
        shutil.copytree(source, folder, ignore=shutil.ignore_patterns("__pycache__"))
        _add_wheels(wheels, folder / "wheels")
        shutil.copy(HERE.parent / "LICENSE", folder)
        shutil.copy(HERE / "comfyui" / "README.md", folder)
        return _pack(folder, Path(temporary), output / f"{source.name}.zip")


def _add_wheels(wheels: Path | None, folder: Path) -> list[str]:
    """Put wheels of weftex into a new folder; return their names."""
    folder.mkdir()
    if wheels is None:
        _pip("wheel", "--no-deps", "--wheel-dir", str(folder), str(HERE.parent))
    else:
        for wheel in sorted(wheels.glob("weftex-*.whl")):
            shutil.copy(wheel, folder)
    own = [one.name for one in folder.iterdir()]
    if not own:
        raise SystemExit(f"{wheels} has no wheels of weftex")
    return own


def _pack(folder: Path, root: Path, path: Path) -> Path:
    """Write the files of a folder as a ZIP file, with names from `root` on; return its path."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for file in sorted(folder.rglob("*")):
            if file.is_file():
                archive.write(file, file.relative_to(root))
    return path


def gimp(wheels: Path | None, output: Path) -> Path:
    """Write the plug-in as a ZIP file that is unpacked in GIMP's folder of plug-ins."""
    return _plug_in("gimp", HERE / "gimp" / "weftex", output)


def krita(wheels: Path | None, output: Path) -> Path:
    """Write the plug-in as a ZIP file that Krita's *Import Python Plugin from File* takes."""
    return _plug_in("krita", HERE / "krita" / "weftex_krita", output)


def _plug_in(host: str, source: Path, output: Path) -> Path:
    """Write a plug-in with the shared files and the options; return its path."""
    output.mkdir(parents=True, exist_ok=True)
    path = output / f"weftex_{host}.zip"
    files = [*sorted(source.iterdir()), *sorted((HERE / "shared").glob("*.py"))]
    files += [HERE / host / "README.md", HERE.parent / "LICENSE"]
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(f"{source.name}/", "")  # by which Krita finds the module
        for file in files:
            if file.is_file():
                archive.write(file, f"{source.name}/{file.name}")
        for beside in sorted((HERE / host).glob("*.desktop")):
            archive.write(beside, beside.name)
        archive.writestr(f"{source.name}/options.json", json.dumps(_declared(), indent=1))
    return path


def _declared() -> dict[str, list[dict[str, Any]]]:
    """Return the options of dialogs by tasks, as weftex declares them."""
    try:
        from weftex.recipe import SEED, TASKS
        from weftex.registry import METHODS
    except ImportError as error:
        raise SystemExit(f"{sys.executable} has no weftex to read options from: {error}") from None

    found = {}
    for task, names in _DIALOGS.items():
        shown = [TASKS[task].options[name] for name in names]
        rows = [{**one.as_json(), "flag": one.flag} for one in (*shown, SEED)]
        holes = task in ("tile", "fill")
        able = [slug for slug in METHODS if not holes or "known" in METHODS[slug].supports]
        choices = [["auto", "Automatic"], *([slug, METHODS[slug].title] for slug in able)]
        method = {"name": "method", "flag": "--method", "type": "text", "choices": choices}
        rows.append({**method, "help": _METHOD, "default": "auto", "default_text": ""})
        keys = ("name", "flag", "type", "help", "default", "default_text", "choices")
        found[task] = [{key: row[key] for key in keys} for row in rows]
    return found


def _pip(*arguments: str) -> None:
    subprocess.run(
        [sys.executable, "-m", "pip", arguments[0], "--quiet", *arguments[1:]], check=True
    )


HOSTS = {"blender": blender, "comfyui": comfyui, "gimp": gimp, "krita": krita}


def main() -> None:
    """Package the integration that the command line names."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("host", choices=list(HOSTS))
    parser.add_argument("--wheels", type=Path, help="folder with wheels of weftex")
    parser.add_argument("--output", type=Path, default=Path("dist"), help="folder to write to")
    given = parser.parse_args()
    print(HOSTS[given.host](given.wheels, given.output))


if __name__ == "__main__":
    main()
