"""Draw the pictures of docs/tutorials/research-tour.md by running its commands.

Each command writes a strip of pictures for one method.

python benchmarks/pages/at_work.py
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

from pictures import commands
from PIL import Image

DOCS = Path(__file__).resolve().parents[2] / "docs"
_ACROSS, _QUALITY = 900, 70


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        for words in commands((DOCS / "tutorials" / "research-tour.md").read_text("utf-8")):
            subprocess.run([sys.executable, "-m", "weftex", *words], cwd=folder, check=True)
            strip = Image.open(Path(folder) / words[2]).convert("RGB")
            strip.thumbnail((_ACROSS, strip.height), Image.Resampling.LANCZOS)
            path = DOCS / "img" / f"at-work-{Path(words[2]).stem}.webp"
            strip.save(path, quality=_QUALITY, method=6)
            print(f"{path}: {path.stat().st_size} bytes")


if __name__ == "__main__":
    main()
