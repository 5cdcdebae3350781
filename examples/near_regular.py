"""Near-regular synthesis: a brick wall that keeps its rows, and a far window of the same wall.

python examples/near_regular.py -o FOLDER
"""

import argparse
from pathlib import Path

import weftex

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("-o", "--output", type=Path, default=Path(), metavar="FOLDER")
folder = parser.parse_args().output
folder.mkdir(parents=True, exist_ok=True)

model = weftex.NearRegular().fit(weftex.load_exemplar("sample:bricks"))
result = model.sample((384, 512), seed=7)
far = model.window(10**9, 10**9, 256, 256, seed=7)

weftex.write_image(folder / "near_regular.png", result.image)
weftex.write_image(folder / "near_regular_sources.png", result.draw("sources"))
weftex.write_image(folder / "near_regular_far.png", far.image)
x1, y1, x2, y2 = model.method.lattice
print(f"{folder / 'near_regular.png'}: vectors [{x1:.1f}, {y1:.1f}] and [{x2:.1f}, {y2:.1f}]")
