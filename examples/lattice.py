"""The lattice of near-regular samples: vectors, confidence, and a picture of it.

python examples/lattice.py -o FOLDER
"""

import argparse
from pathlib import Path

import weftex
from weftex.analysis.lattice import find_lattice
from weftex.analysis.overlay import draw_lattice

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("-o", "--output", type=Path, default=Path(), metavar="FOLDER")
folder = parser.parse_args().output
folder.mkdir(parents=True, exist_ok=True)

here = Path(__file__).parent / "samples"
names = ["sample:bricks", "sample:tiles", "sample:weave", "sample:grass"]
names += [str(here / f"{name}.png") for name in ("fence", "gingham", "mosaic", "boards")]
for name in names:
    sample = weftex.load_exemplar(name)
    lattice = find_lattice(sample)
    short = Path(name.removeprefix("sample:")).stem
    if lattice is None:
        print(f"{short:8} no lattice")
        continue
    vectors = " ".join(f"[{x:7.2f}, {y:7.2f}]" for x, y in lattice.vectors)
    print(f"{short:8} {vectors:40} confidence {lattice.confidence:.2f}")
    weftex.write_image(folder / f"lattice_{short}.png", draw_lattice(sample, lattice))
