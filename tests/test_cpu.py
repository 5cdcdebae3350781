"""Kernels for the processor at hand and for any: the same bytes."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

import weftex

FOLDER = Path(weftex.__file__).parent
SCRIPT = """
import hashlib, importlib, sys
import numpy as np
import weftex
from families import TRIALS, canvas_of, kinds_of, method_of

chosen = [importlib.import_module(name) for name in sys.argv[1:]]
print(*("avx2" if "_avx2" in m.__file__ else "baseline" for m in chosen))
pebbles = weftex.load_exemplar("sample:pebbles").pixels[:60, :65]
y, x = np.indices((50, 55))
hole = (y - 22) ** 2 + (x - 25) ** 2 < 200
known = pebbles[:50, 5:60].copy()
known[hole] = 0
alpha = np.concatenate([pebbles, pebbles[..., :1]], axis=2)
samples = {"bytes": pebbles, "gray": pebbles[..., 0].copy(), "alpha": alpha,
           "deep": pebbles.astype(np.uint16) * 257, "real": (pebbles / 255).astype(np.float32)}
canvases = {"plain": weftex.Canvas(70, 76), "tileable": weftex.Canvas(70, 76, (True, True)),
            "hole": weftex.Canvas(50, 55, known=known, hole=hole)}
for method in (m for m in weftex.METHODS if TRIALS[m].family == "patch"):
    for search in ("exhaustive", "quadtree", "pca", "kdtree", "kdtree-pca"):
        for name, sample in samples.items():
            for kind, canvas in canvases.items():
                if search != "pca" and name != "bytes" or kind == "hole" and name != "bytes":
                    continue
                for blend in ("feather", "feather-at-end", "cut"):
                    if blend == "feather-at-end" and search != "pca":
                        continue
                    kind_of = weftex.METHODS[method](patch_size=13, search=search, blend=blend)
                    result = kind_of.fit(weftex.Exemplar(sample)).sample(canvas, seed=3)
                    whole = hashlib.sha256()
                    parts = [result.image, result.placements, result.cuts, *result.layers()]
                    base = known.repeat(2, 0).repeat(2, 1) if kind == "hole" else None
                    parts.append(result.render(sample.repeat(2, 0).repeat(2, 1), background=base))
                    for part in parts:
                        whole.update(np.ascontiguousarray(part).tobytes())
                    print(method, search, name, kind, blend, whole.hexdigest())
for method in (m for m in weftex.METHODS if TRIALS[m].family == "pixel"):
    for way in TRIALS[method].ways:
        model = method_of(method, way).fit(weftex.Exemplar(pebbles))
        for kind in kinds_of(method, way):
            result = model.sample(canvas_of(kind, pebbles), seed=3)
            parts = result.image.tobytes() + result.source.tobytes()
            print(method, way, kind, hashlib.sha256(parts).hexdigest())
"""


KERNELS = [
    ".".join(("weftex", *file.relative_to(FOLDER / "_avx2").parent.parts, file.name.split(".")[0]))
    for file in sorted((FOLDER / "_avx2").rglob("*.*"))
    if file.suffix in (".so", ".pyd")
]


def run(**environment):
    folders = [str(Path(__file__).parent), os.environ.get("PYTHONPATH", "")]
    environment |= {"PYTHONPATH": os.pathsep.join(folders)}
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT, *KERNELS],
        env={k: v for k, v in os.environ.items() if k != "WEFTEX_KERNELS"} | environment,
        capture_output=True,
        check=False,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    first, *lines = done.stdout.splitlines()
    return first, lines


def fast():
    """Whether this machine and this build have kernels of both kinds."""
    try:
        from numpy._core._multiarray_umath import __cpu_features__ as features
    except ImportError:
        return False
    return bool(features.get("AVX2")) and (FOLDER / "_avx2").is_dir()


@pytest.mark.skipif(not fast(), reason="no AVX2 here, or not built for it")
def test_kernels_of_both_kinds_make_the_same_bytes():
    """All methods, every kind of canvas, search, depth and seam."""
    kind, expected = run(WEFTEX_KERNELS="baseline")
    assert kind.split() == ["baseline"] * len(KERNELS) and len(KERNELS) >= 5
    kind, found = run()
    assert kind.split() == ["avx2"] * len(KERNELS)
    assert len(found) > 80
    assert found == expected


@pytest.mark.skipif(not fast(), reason="no AVX2 here, or not built for it")
@pytest.mark.parametrize(
    "first",
    [
        *(
            f"weftex.synthesize(np.zeros((20, 20), np.uint8), 30, method='{m}')"
            for m in weftex.METHODS
            if m != "best-tile"
        ),
        "weftex.PatchSampling(patch_size=4).fit(weftex.Exemplar(np.zeros((20, 20), np.uint8)))",
        "weftex.Synthesis, weftex.Quilting().fit(weftex.Exemplar(np.zeros((20, 20), np.uint8)))",
    ],
)
def test_every_kernel_is_the_fast_one_whatever_is_used_first(first):
    script = (
        f"import sys, numpy as np, weftex; {first}\n"
        "for name, module in list(sys.modules.items()):\n"
        "    if name.startswith('weftex') and name.endswith('kernels'):\n"
        "        print(name, '_avx2' in module.__file__)"
    )
    done = subprocess.run(
        [sys.executable, "-c", script],
        env={k: v for k, v in os.environ.items() if k != "WEFTEX_KERNELS"},
        capture_output=True,
        check=False,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert lines
    assert [line for line in lines if line.endswith("False")] == []
