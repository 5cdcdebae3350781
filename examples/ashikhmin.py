"""Coherent candidates: pieces of the sample, of any shape, that grow until another fits better.

python examples/ashikhmin.py -o FOLDER
"""

import argparse
from pathlib import Path

import weftex

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("-o", "--output", type=Path, default=Path(), metavar="FOLDER")
folder = parser.parse_args().output
folder.mkdir(parents=True, exist_ok=True)

sample = weftex.load_exemplar("sample:pebbles")
model = weftex.Ashikhmin(window_width=5, passes=2).fit(sample)
result = model.sample((384, 512), seed=7)

weftex.write_image(folder / "ashikhmin.png", result.image)
weftex.write_image(folder / "ashikhmin_sources.png", result.draw("sources"))
print(f"{folder / 'ashikhmin.png'}: made; its sources in false colors are beside it")
