"""Kernels for the processor at hand and for any: the same bytes."""

import os
from pathlib import Path

import pytest

import weftex
from processes import run

FOLDER = Path(weftex.__file__).parent
SCRIPT = """
import hashlib, importlib, sys
import numpy as np
import weftex
from families import SEARCHES, TRIALS, canvas_of, kinds_of, method_of

chosen = [importlib.import_module(name) for name in sys.argv[1:]]
print(*("avx2" if "_avx2" in m.__file__ else "baseline" for m in chosen))
pebbles = weftex.load_exemplar("sample:pebbles").pixels[:40, :44]
alpha = np.concatenate([pebbles, pebbles[..., :1]], axis=2)
samples = {"bytes": pebbles, "gray": pebbles[..., 0].copy(), "alpha": alpha,
           "deep": pebbles.astype(np.uint16) * 257, "real": (pebbles / 255).astype(np.float32)}

def show(model, canvas, *about):
    result = model.sample(canvas, seed=3)
    parts = [result.image, result.source, *result.layers()]
    if result.canvas.hole is None:
        parts.append(result.render(model.exemplar.pixels.repeat(2, 0).repeat(2, 1)))
    whole = b"".join(np.ascontiguousarray(part).tobytes() for part in parts)
    print(*about, hashlib.sha256(whole).hexdigest())

for method, trial in TRIALS.items():
    for way in trial.ways:
        model = method_of(method, way).fit(weftex.Exemplar(pebbles))
        for kind in kinds_of(method, way):
            show(model, canvas_of(kind, pebbles), method, way, kind)
    for search in SEARCHES if trial.family == "patch" else ():
        for name, sample in samples.items():
            model = weftex.METHODS[method](patch_size=13, search=search).fit(sample)
            show(model, weftex.Canvas(70, 76), method, search, name)
"""


KERNELS = [
    ".".join(("weftex", *file.relative_to(FOLDER / "_avx2").parent.parts, file.name.split(".")[0]))
    for file in sorted((FOLDER / "_avx2").rglob("*.*"))
    if file.suffix in (".so", ".pyd")
]


def in_a_process(script, *words, **environment):
    """What a script prints, line by line; kernels are chosen by the machine unless named."""
    folders = [str(Path(__file__).parent), os.environ.get("PYTHONPATH", "")]
    plain = {k: v for k, v in os.environ.items() if k != "WEFTEX_KERNELS"}
    paths = {"PYTHONPATH": os.pathsep.join(folders)}
    done = run(script, *words, env=plain | paths | environment, timeout=None)
    return done.stdout.splitlines()


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
    kind, *expected = in_a_process(SCRIPT, *KERNELS, WEFTEX_KERNELS="baseline")
    assert kind.split() == ["baseline"] * len(KERNELS) and len(KERNELS) >= 5
    kind, *found = in_a_process(SCRIPT, *KERNELS)
    assert kind.split() == ["avx2"] * len(KERNELS)
    assert len(found) > 80
    assert found == expected


@pytest.mark.skipif(not fast(), reason="no AVX2 here, or not built for it")
@pytest.mark.parametrize("first", ["Synthesis", *(cls.__name__ for cls in weftex.METHODS.values())])
def test_every_kernel_is_the_fast_one_whatever_is_used_first(first):
    script = (
        f"import sys, weftex; weftex.{first}, weftex.Quilting().fit('sample:grass')\n"
        "for name, module in list(sys.modules.items()):\n"
        "    if name.startswith('weftex') and name.endswith('kernels'):\n"
        "        print(name, '_avx2' in module.__file__)"
    )
    lines = in_a_process(script)
    assert lines
    assert [line for line in lines if line.endswith("False")] == []
