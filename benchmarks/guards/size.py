"""Print how large the code base is, and how much there is to read for each method.

    python benchmarks/guards/size.py

`tests/test_size.py` holds the first table as ceilings. The second counts, for each method, the
files and lines of `methods`, `repeats`, `search` and `seams` that it imports, kernels and their
declarations included; and the same for everything that it imports.
"""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[2] / "tests"))
import weftex
from test_dependencies import LEVEL, arrows, circles, room
from test_size import CEILINGS, lines_of, measured, modules_of, to_read


def main() -> None:
    upward = [pair for pair in arrows() if LEVEL[room(pair[0])] < LEVEL.get(room(pair[1]), 99)]
    print(f"{len(list(arrows()))} imports, {len(circles())} circles, {len(upward)} upward\n")
    print("| measure | now | ceiling |\n|---|---|---|")
    found = measured()
    for name, ceiling in CEILINGS.items():
        print(f"| {name} | {found[name]:,} | {ceiling:,} |")
    print("\n| method | files | lines | all files | all lines |\n|---|---|---|---|---|")
    for slug in weftex.METHODS:
        cells = []
        for modules in (to_read(slug), modules_of(slug)):
            cells += [str(len(modules)), f"{lines_of(modules):,}"]
        print(f"| {slug} | " + " | ".join(cells) + " |")


if __name__ == "__main__":
    main()
