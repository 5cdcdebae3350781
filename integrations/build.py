"""Package an integration as the file that its host program installs.

    python integrations/build.py blender [--wheels FOLDER] [--output FOLDER]

Wheels of weftex are taken from the folder, for each system that it has one for; without a folder
one is built for this machine. The packages that weftex needs besides NumPy and OpenImageIO, which
Blender and arrays do without, are pure Python and come from the package index.
"""

from __future__ import annotations

import argparse
import shutil
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
_PURE = ["threadpoolctl>=3.1", "tqdm>=4.66"]
#: Blender's names of systems, by a part of the names of wheels.
_SYSTEMS = {
    "linux_x86_64": "linux-x64",
    "x86_64.whl": "linux-x64",
    "macosx": "macos-arm64",
    "win_amd64": "windows-x64",
}


def blender(wheels: Path | None, output: Path) -> Path:
    """Write the extension as a ZIP file with its wheels, and return its path."""
    source = HERE / "blender" / "weftex_blender"
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary) / source.name
        shutil.copytree(source, folder, ignore=shutil.ignore_patterns("__pycache__"))
        kept = folder / "wheels"
        kept.mkdir()
        if wheels:
            for wheel in sorted(wheels.glob("weftex-*.whl")):
                shutil.copy(wheel, kept)
        else:
            _pip("wheel", "--no-deps", "--wheel-dir", str(kept), str(HERE.parent))
        own = [one.name for one in kept.iterdir()]
        if not own:
            raise SystemExit(f"{wheels} has no wheels of weftex")
        _pip("download", "--no-deps", "--only-binary=:all:", "--dest", str(kept), *_PURE)
        systems = sorted({name for part, name in _SYSTEMS.items() for one in own if part in one})
        manifest = folder / "blender_manifest.toml"
        head, permissions = manifest.read_text("utf-8").split("\n[permissions]")
        listed = ", ".join(f'"./wheels/{one.name}"' for one in sorted(kept.iterdir()))
        named = ", ".join(f'"{name}"' for name in systems)
        lines = f"platforms = [{named}]\nwheels = [{listed}]\n"
        manifest.write_text(f"{head}{lines}\n[permissions]{permissions}", "utf-8")
        shutil.copy(HERE.parent / "LICENSE", folder)
        output.mkdir(parents=True, exist_ok=True)
        path = output / f"{source.name}.zip"
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
            for file in sorted(folder.rglob("*")):
                if file.is_file():
                    archive.write(file, file.relative_to(folder))
    return path


def _pip(*arguments: str) -> None:
    subprocess.run(
        [sys.executable, "-m", "pip", arguments[0], "--quiet", *arguments[1:]], check=True
    )


def main() -> None:
    """Package the integration that the command line names."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("host", choices=["blender"])
    parser.add_argument("--wheels", type=Path, help="folder with wheels of weftex")
    parser.add_argument("--output", type=Path, default=Path("dist"), help="folder to write to")
    given = parser.parse_args()
    print(blender(given.wheels, given.output))


if __name__ == "__main__":
    main()
