"""Digests of what every method makes: a refactoring must not change a byte of any output.

    python benchmarks/guards/digests.py                  # compare: both builds, 1 and 2 threads
    python benchmarks/guards/digests.py --only graphcut  # only the cases whose name contains this
    python benchmarks/guards/digests.py --write          # after a change of pixels that is wanted

A case is METHOD/WAY/CANVAS/PIXELS. Its digest covers the picture, the source coordinates, the
layers with their weights, and the maps replayed. Samples are crops of the packaged ones.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

import weftex
from weftex.atlas import atlas

HERE = Path(__file__).resolve().parent
RECORD = HERE.parent / "data" / "digests.json"
sys.path.append(str(HERE.parents[1] / "tests"))
from families import BLENDS, SEARCHES, TRIALS, canvas_of, kinds_of, method_of  # noqa: E402

Case = tuple[str, Callable[[], Any]]
FILLS = ("patch-sampling", "quilting", "graphcut", "efros-leung", "wei-levoy", "ashikhmin")
FILLS += ("exact-matching", "refinement", "near-regular", "best-tile")
#: Where whole tiles nearly fit, so that what goes around need not be strained much.
SIZES = {"bricks": (157, 132), "tiles": (186, 161)}
#: Ways beside those of tests/families.py, each on the material that it is for.
MORE: dict[str, dict[str, tuple[str, dict[str, Any]]]] = {
    "patch-sampling": {
        "similarity": ("pebbles", {"choice": "similarity", "epsilon": 0.4, "patch_size": 24}),
        "paper": ("weave", {"search": "quadtree", "repeat_distance": 0.0, "epsilon": 0.2}),
    },
    "quilting": {"wide": ("bricks", {"boundary_width": 12, "patch_size": 40, "tolerance": 0.3})},
    "graphcut": {"refined": ("leaves", {"patch_size": 40}), "default": ("bricks", {})},
    "wei-levoy": {
        "constrained": ("grass", {"window_width": 5, "levels": 3}),
        "full": ("weave", {"search": "full", "window_width": 7, "levels": 2}),
    },
    "ashikhmin": {"wide": ("leaves", {"window_width": 9})},
    "exact-matching": {
        "one level": ("bricks", {"levels": 1, "window_width": 11}),
        "few compared": ("tiles", {"candidates": 20}),
    },
    "refinement": {
        "joints": ("bricks", {"joints": 12}),
        "paper": ("pebbles", {"search": "nearest", "init": "seeds"}),
        "from graphcut": ("leaves", {"init": "graphcut"}),
        "from quilting": ("grass", {"init": "quilting"}),
    },
    "near-regular": {
        "paper": ("bricks", {"defaults": "paper"}),
        "rows": ("wood", {"lattice": (16, 0, 0, 1)}),
        "weave": ("weave", {}),
        "gncc": ("bricks", {"match": "gncc"}),
        "feathered": ("tiles", {"blend": "feather", "blend_width": 8}),
    },
    "best-tile": {"bricks": ("bricks", {"lattice": (63, 42, 63, -42)})},
}


@cache
def sample(name: str, side: int = 192) -> np.ndarray:
    pixels = weftex.load_exemplar(f"sample:{name}").pixels
    return np.ascontiguousarray(pixels[:side, :side])


def formats() -> dict[str, weftex.Exemplar]:
    """A small sample in every dtype, with and without color, alpha, maps and a mask."""
    pebbles = sample("pebbles", 66)[:60]
    if pebbles.ndim == 2:
        pebbles = np.repeat(pebbles[..., None], 3, axis=2)
    grey = pebbles[..., 0].copy()
    alpha = np.concatenate([pebbles, pebbles[..., :1]], axis=2)
    maps = {
        "height": grey.astype(np.uint16) * 257,
        "normal": pebbles[::-1].copy(),
        "ao": (grey / 255).astype(np.float32),
    }
    mask = np.ones(grey.shape, bool)
    mask[20:23, 30:34] = False
    return {
        "8 bit": weftex.Exemplar(pebbles),
        "grey": weftex.Exemplar(grey),
        "alpha": weftex.Exemplar(alpha),
        "16 bit": weftex.Exemplar(pebbles.astype(np.uint16) * 257),
        "float": weftex.Exemplar((pebbles / 255).astype(np.float32)),
        "maps": weftex.Exemplar(pebbles, maps=maps),
        "mask": weftex.Exemplar(pebbles, mask=mask),
        "tileable": weftex.Exemplar(pebbles, tileable=True),
    }


def digest(result: Any) -> str:
    """Of everything that a result shows."""
    whole = hashlib.sha256()
    parts = [result.image, result.source, *result.layers()]
    parts += [pixels for _, pixels in sorted(result.maps.items())]
    for part in parts:
        part = np.ascontiguousarray(part)
        whole.update(f"{part.shape} {part.dtype}".encode() + part.tobytes())
    return whole.hexdigest()[:16]


def made(method: Any, exemplar: weftex.Exemplar, canvas: Any, threads: int) -> str:
    return digest(method.fit(exemplar).sample(canvas, seed=5, threads=threads))


def cases(threads: int) -> Iterator[Case]:
    """Every case by its name."""
    for slug in FILLS:
        yield from small_cases(slug, threads)
        yield from material_cases(slug, threads)
    yield from patch_cases(threads)
    yield from window_cases(threads)
    yield from atlas_cases(threads)
    yield from fused_cases(threads)
    yield from task_cases(threads)


def small_cases(slug: str, threads: int) -> Iterator[Case]:
    """Every way on every canvas; every sort of pixels on three."""
    every = formats()
    for number, way in enumerate(TRIALS[slug].ways):
        for sort, exemplar in every.items():
            kinds = kinds_of(slug, way)
            if sort != "8 bit":
                kinds = [k for k in kinds if k in ("plain", "xy", "hole")] if number == 0 else []
            if sort == "maps":
                kinds = [k for k in kinds if k != "hole"]  # see task_cases
            for kind in kinds:
                yield (
                    f"{slug}/{way or 'small'}/{kind}/{sort}",
                    lambda w=way, k=kind, e=exemplar: made(
                        method_of(slug, w), e, canvas_of(k, e.pixels), threads
                    ),
                )


def material_cases(slug: str, threads: int) -> Iterator[Case]:
    """Defaults, and ways of its own, on materials of a real size."""
    regular = slug in ("near-regular", "best-tile")
    side = 192 if regular else 48 if slug == "efros-leung" else 128
    usual = {"near-regular": "bricks", "best-tile": "tiles"}.get(slug, "pebbles")
    ways: dict[str, Any] = {"default": (usual, {})}
    for way, (name, parameters) in (ways | MORE.get(slug, {})).items():
        exemplar = weftex.Exemplar(sample(name, side))
        size = (72, 70) if slug == "efros-leung" else SIZES.get(name, (150, 161))
        wraps = {"plain": (False, False), "xy": (True, True)}
        for kind, wrap in wraps.items():
            canvas = weftex.Canvas(*size, wrap)
            yield (
                f"{slug}/{way}/{kind}/{name}",
                lambda p=parameters, e=exemplar, c=canvas: made(
                    weftex.METHODS[slug](**p), e, c, threads
                ),
            )


def patch_cases(threads: int) -> Iterator[Case]:
    """Every search with every way of joining."""
    exemplar = formats()["8 bit"]
    for slug in ("patch-sampling", "quilting"):
        for search in SEARCHES:
            for blend in BLENDS:
                for kind in ("plain", "xy", "hole"):
                    method = {"patch_size": 13, "search": search, "blend": blend}
                    yield (
                        f"{slug}/{search} {blend}/{kind}/8 bit",
                        lambda s=slug, m=method, k=kind: made(
                            weftex.METHODS[s](**m), exemplar, canvas_of(k, exemplar.pixels), threads
                        ),
                    )


def window_cases(threads: int) -> Iterator[Case]:
    """Windows of an endless plane."""
    for slug, name in (("near-regular", "bricks"), ("best-tile", "tiles")):
        for y, x in ((0, 0), (-70, 1000), (2**33, -(2**35) - 3)):
            yield (
                f"{slug}/default/window {y} {x}/{name}",
                lambda s=slug, n=name, y=y, x=x: digest(
                    weftex.METHODS[s]()
                    .fit(weftex.Exemplar(sample(n)))
                    .window(y, x, 90, 110, seed=5)
                ),
            )
    exemplar = weftex.Exemplar(sample("bricks"))
    for slug in ("patch-sampling", "quilting", "graphcut", "refinement"):
        for period in (None, (1000, 1030)):
            yield (
                f"{slug}/default/window {period or 'endless'}/bricks",
                lambda s=slug, p=period: digest(
                    weftex.METHODS[s]()
                    .fit(exemplar)
                    .window(2**33, -40, 90, 110, seed=5, period=p, threads=threads)
                ),
            )


def atlas_cases(threads: int) -> Iterator[Case]:
    """All corner tiles, whose tones and heights are joined within each."""
    maps = formats()["maps"]
    for name, exemplar in (("bricks", weftex.Exemplar(sample("bricks"))), ("maps", maps)):
        yield (
            f"auto/atlas/torus/{name}",
            lambda e=exemplar: digest(atlas(e, tile_size=48, seed=5, threads=threads).synthesis),
        )


def fused_cases(threads: int) -> Iterator[Case]:
    """Materials that meet along curves, in a painted map and in a gradient."""
    materials = [sample(name, 80) for name in ("pebbles", "leaves", "bricks")]
    y, x = np.indices((120, 130))
    waves = (x + 8 * np.sin(y / 15) > 65).astype(np.uint8)
    three = waves + (y > 70) * (waves == 1)
    able = ("efros-leung", "wei-levoy", "ashikhmin", "exact-matching", "refinement")
    for slug in able:
        small = {"window_width": 5} if slug == "efros-leung" else {}
        half = slice(None, None, 2 if slug == "efros-leung" else 1)
        yield (
            f"{slug}/fused/two/8 bit",
            lambda s=slug, p=small, h=half: digest(
                weftex.fuse([m[:64, :64] for m in materials[:2]], waves[h, h], method=s, seed=5,
                          threads=threads, **p)
            ),
        )  # fmt: skip
    yield (
        "auto/fused/three/8 bit",
        lambda: digest(weftex.fuse(materials, three.astype(np.uint8), seed=5, threads=threads)),
    )
    yield (
        "auto/fused/tileable/8 bit",
        lambda: digest(weftex.fuse(materials[:2], waves, seed=5, tileable="y", threads=threads)),
    )
    yield (
        "auto/fused/gradient/8 bit",
        lambda: digest(
            weftex.fuse(materials[:2], "gradient", size=(160, 100), seed=5, threads=threads)
        ),
    )
    mixed = np.where(abs(x - 65) < 25, 2, x > 65).astype(np.uint8)
    yield (
        "refinement/fused/mixed/8 bit",
        lambda: digest(
            weftex.fuse(
                materials[:2], mixed, mixed={2: (0, 1)}, colors=[0, 1], seed=5, threads=threads
            )
        ),
    )


def task_cases(threads: int) -> Iterator[Case]:
    """What the tasks choose by themselves: the method, and how a hole is filled."""
    for name in ("bricks", "grass", "leaves", "pebbles", "stone_wall", "tiles", "weave", "wood"):
        for tileable in (False, True):
            yield (
                f"auto/default/{'xy' if tileable else 'plain'}/{name}",
                lambda n=name, t=tileable: digest(
                    weftex.synthesize(
                        f"sample:{n}", (200, 190), seed=5, tileable=t, threads=threads
                    )
                ),
            )
    y, x = np.indices((128, 128))
    hole = (y - 60) ** 2 + (x - 70) ** 2 < 500
    wide = np.zeros(weftex.load_exemplar("sample:stone_wall").shape, bool)
    wide[40:75, 50:90] = True
    for name in ("bricks", "leaves"):
        for slug in ("auto", *(slug for slug in FILLS if "known" in weftex.METHODS[slug].supports)):
            given = {"exact-matching": {"levels": 1}, "efros-leung": {"window_width": 7}}
            small = given.get(slug, {})
            yield (
                f"{slug}/filled/hole/{name}",
                lambda n=name, s=slug, p=small: digest(
                    weftex.fill(sample(n, 128), hole, method=s, seed=5, threads=threads, **p)
                ),
            )
    for slug in ("auto", "graphcut", "refinement"):
        yield (
            f"{slug}/filled/hole/stone_wall with maps",
            lambda s=slug: digest(
                weftex.fill("sample:stone_wall", wide, method=s, seed=5, threads=threads)
            ),
        )
    yield (
        "auto/filled/from a sample/bricks",
        lambda: digest(
            weftex.fill(
                sample("bricks", 128), hole, sample=sample("bricks"), seed=5, threads=threads
            )
        ),
    )
    yield (
        "quilting/best of 3/plain/bricks",
        lambda: digest(
            weftex.synthesize(
                sample("bricks"), 160, seed=5, method="quilting", best_of=3, threads=threads
            )
        ),
    )
    yield (
        "ashikhmin/guided/guide/pebbles",
        lambda: digest(
            weftex.synthesize(
                sample("pebbles", 96), 100, method="ashikhmin", guide=sample("leaves", 100), seed=5,
                threads=threads,
            )
        ),
    )  # fmt: skip


def computed(only: str, threads: int) -> dict[str, str]:
    """The digests of the cases whose name contains a text; an error counts as an outcome."""
    found = {}
    for name, work in cases(threads):
        if only in name:
            try:
                found[name] = work()
            except weftex.WeftexError as error:
                found[name] = type(error).__name__
    return found


def in_process(only: str, threads: int, kernels: str) -> dict[str, str]:
    environment = {k: v for k, v in os.environ.items() if k != "WEFTEX_KERNELS"}
    if kernels == "baseline":
        environment["WEFTEX_KERNELS"] = "baseline"
    words = [sys.executable, __file__, "--one", str(threads), "--only", only]
    done = subprocess.run(words, env=environment, stdout=subprocess.PIPE, text=True, check=True)
    return dict(json.loads(done.stdout))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--only", default="", help="cases whose name contains this")
    parser.add_argument("--write", action="store_true", help="record instead of comparing")
    parser.add_argument("--quick", action="store_true", help="one build, one thread")
    parser.add_argument("--one", type=int, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.one:
        print(json.dumps(computed(given.only, given.one)))
        return 0
    record = json.loads(RECORD.read_text()) if RECORD.exists() else {}
    if given.write:
        fresh = in_process(given.only, 2, "fast")
        kept = {k: v for k, v in record.items() if given.only not in k}
        RECORD.write_text(json.dumps(kept | fresh, indent=0, sort_keys=True) + "\n")
        print(f"{len(fresh)} digests written to {RECORD.name}")
        return 0
    expected = {name: value for name, value in record.items() if given.only in name}
    build = "baseline" if os.environ.get("WEFTEX_KERNELS") == "baseline" else "fast"
    runs = [(build, 2)] if given.quick else [(k, t) for k in ("fast", "baseline") for t in (1, 2)]
    wrong = 0
    for kernels, threads in runs:
        found = in_process(given.only, threads, kernels)
        differ = sorted(n for n in expected | found if expected.get(n) != found.get(n))
        for name in differ:
            print(f"{name}: {expected.get(name, 'absent')} is now {found.get(name, 'absent')}")
        wrong += len(differ)
        equal = f"{len(found) - len(differ)} of {len(found)} equal"
        print(f"{equal}, {kernels} kernels, {threads} threads")
    return wrong > 0


if __name__ == "__main__":
    sys.exit(main())
