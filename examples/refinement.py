"""Iterative refinement: an initial image improves until every window is like the sample's.

python examples/refinement.py -o FOLDER
"""

import argparse
from pathlib import Path

import weftex

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("-o", "--output", type=Path, default=Path(), metavar="FOLDER")
folder = parser.parse_args().output
folder.mkdir(parents=True, exist_ok=True)

sample = weftex.load_exemplar("sample:stone_wall")
model = weftex.Refinement().fit(sample)
result = model.sample((384, 512), seed=7)

weftex.write_image(folder / "refinement.png", result.image)
weftex.write_image(folder / "refinement_sources.png", result.draw("sources"))
curve = result.provenance["convergence"]
print(f"{folder / 'refinement.png'}: windows of {model.method.window_width} px")
print(f"{len(curve)} iterations on {result.provenance['levels']} levels; the last changed "
      f"{curve[-1]['changed']:.1%} of the pixels")  # fmt: skip
