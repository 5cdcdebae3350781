"""Non-parametric sampling: a picture grown pixel by pixel, and where its pixels come from.

python examples/efros_leung.py -o FOLDER
"""

import argparse
from pathlib import Path

import weftex

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("-o", "--output", type=Path, default=Path(), metavar="FOLDER")
folder = parser.parse_args().output
folder.mkdir(parents=True, exist_ok=True)

sample = weftex.load_exemplar("sample:weave")
model = weftex.EfrosLeung(window_width=15).fit(sample)
result = model.sample((96, 128), seed=7, tileable=True)

weftex.write_image(folder / "efros_leung.png", result.image)
weftex.write_image(folder / "efros_leung_sources.png", result.draw("sources"))
print(f"{folder / 'efros_leung.png'}: each pixel by the 15x15 around it")
