"""Best tile repetition: the tile of a wall whose borders fit each other best, over and over.

python examples/best_tile.py -o FOLDER
"""

import argparse
from pathlib import Path

import weftex

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("-o", "--output", type=Path, default=Path(), metavar="FOLDER")
folder = parser.parse_args().output
folder.mkdir(parents=True, exist_ok=True)

model = weftex.BestTile().fit(weftex.load_exemplar("sample:tiles"))
result = model.sample((384, 512))

weftex.write_image(folder / "best_tile.png", result.image)
print(f"{folder / 'best_tile.png'}: the tile at row, column {list(model.anchor)}")
