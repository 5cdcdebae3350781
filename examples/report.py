"""How good a result is: two results of one sample, their figures, and a page to read.

python examples/report.py -o FOLDER
"""

import argparse
from pathlib import Path

import weftex

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("-o", "--output", type=Path, default=Path(), metavar="FOLDER")
folder = parser.parse_args().output
folder.mkdir(parents=True, exist_ok=True)

# Patches of 8 pixels are too small for pebbles.
for patch_size in (None, 8):
    made = weftex.synthesize(
        "sample:pebbles", 256, method="quilting", patch_size=patch_size, seed=1, tileable=True
    )
    found = weftex.pages.report("sample:pebbles", made)
    figures = found.assessment
    print(f"patch size {patch_size or 'by sample'}: score {figures.score:.2f}")
    print(f"  {figures.verdict()}")
    print(f"  patches {figures.patches}; real: {found.real['patches']}")
    found.save(folder / f"report_{patch_size or 'auto'}.html")
