"""Patch-based sampling: one sample, one analysis, several outputs.

python examples/patch_sampling.py -o FOLDER
"""

import argparse
from pathlib import Path

import weftex

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("-o", "--output", type=Path, default=Path(), metavar="FOLDER")
folder = parser.parse_args().output
folder.mkdir(parents=True, exist_ok=True)

sample = weftex.load_exemplar("sample:pebbles")

# Fitting is the papers' analysis; the model then makes any number of outputs.
model = weftex.PatchSampling(patch_size=48, epsilon=0.2).fit(sample)
for seed in (1, 2):
    result = model.sample((384, 512), seed=seed)
    path = folder / f"patch_sampling_{seed}.png"
    weftex.write_image(path, result.image)
    print(f"{path}: {len(result.placements)} patches of {model.method.patch_size} px")

# The answer behind the picture: where each pixel comes from, and where patches meet.
print("the first pixel comes from row and column", result.source[0, 0].tolist())
weftex.write_image(folder / "patch_sampling_seams.png", result.draw("seams"))
weftex.write_image(folder / "patch_sampling_sources.png", result.draw("sources"))
