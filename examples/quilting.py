"""Image quilting: patches cut along the path where they differ least.

python examples/quilting.py -o FOLDER
"""

import argparse
from pathlib import Path

import weftex

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("-o", "--output", type=Path, default=Path(), metavar="FOLDER")
folder = parser.parse_args().output
folder.mkdir(parents=True, exist_ok=True)

sample = weftex.load_exemplar("sample:leaves")
model = weftex.Quilting(patch_size=64, tolerance=0.1).fit(sample)
result = model.sample((384, 512), seed=7)

weftex.write_image(folder / "quilting.png", result.image)
weftex.write_image(folder / "quilting_cuts.png", result.draw("seams"))
print(f"{folder / 'quilting.png'}: {len(result.placements)} patches, cut where they differ least")
