"""Wei and Levoy's method: scan order, L-shaped windows over a pyramid, a tree for the search.

python examples/wei_levoy.py -o FOLDER
"""

import argparse
from pathlib import Path

import weftex

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("-o", "--output", type=Path, default=Path(), metavar="FOLDER")
folder = parser.parse_args().output
folder.mkdir(parents=True, exist_ok=True)

sample = weftex.load_exemplar("sample:pebbles")
model = weftex.WeiLevoy().fit(sample)
result = model.sample((256, 320), seed=7, tileable=True)

weftex.write_image(folder / "wei_levoy.png", result.image)
weftex.write_image(folder / "wei_levoy_sources.png", result.draw("sources"))
settled = model.method
print(
    f"{folder / 'wei_levoy.png'}: {settled.levels} levels, windows of {settled.window_width} "
    f"and {settled.parent_width} pixels"
)
