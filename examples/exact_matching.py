"""Exact neighborhood matching: the values of the parameters, an output, and its cost.

python examples/exact_matching.py -o FOLDER
"""

import argparse
from pathlib import Path

import weftex

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("-o", "--output", type=Path, default=Path(), metavar="FOLDER")
folder = parser.parse_args().output
folder.mkdir(parents=True, exist_ok=True)

model = weftex.ExactMatching().fit(weftex.load_exemplar("sample:bricks"))
settled = model.method
print(f"windows of {settled.window_width} px, a {settled.init} beginning")

result = model.sample((300, 400), seed=7)
weftex.write_image(folder / "exact_matching.png", result.image)
weftex.write_image(folder / "exact_matching_sources.png", result.draw("sources"))
facts = result.provenance
compared = facts["windows_compared"] / facts["pixels_chosen"]
print(f"{folder / 'exact_matching.png'}: {compared:.1f} windows compared for each pixel")
