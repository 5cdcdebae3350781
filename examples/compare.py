"""Some methods on one sample, side by side: one page with pictures, sources, figures and times.

python examples/compare.py -o FOLDER
"""

import argparse
from pathlib import Path

import weftex

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("-o", "--output", type=Path, default=Path(), metavar="FOLDER")
folder = parser.parse_args().output
folder.mkdir(parents=True, exist_ok=True)

sample = weftex.load_exemplar("sample:weave")
small = weftex.Exemplar(sample.pixels[:96, :96], name="weave")
methods = ["quilting", "near-regular", "ashikhmin"]
found = weftex.pages.compare(small, 128, methods=methods, seed=7)
print(f"auto: {found.choice.reason}")
for entry in found.entries:
    print(f"{entry.method:16} {entry.seconds:6.2f} s  {entry.assessment.verdict()}")
found.save(folder / "compare.html")

# Of two seeds the best by the same figures.
best = weftex.synthesize(small, 128, seed=7, best_of=2)
print(best.provenance["best_of"]["told"])
weftex.write_image(folder / "best_of.png", best.image)
