"""The patch methods: speed beside targets, growth, what the searches find, the paper's tables."""

from __future__ import annotations

import statistics
from typing import Any

import numpy as np
from shared import (
    PATCH_METHODS,
    Table,
    Work,
    child,
    fitting,
    medians,
    ms,
    paper,
    papers,
    sample_of,
    sampling,
    sized,
    some,
)

import weftex
from weftex.results.patches import PatchSynthesis


def speed() -> Table:
    """Fit and sample beside the targets, with the exhaustive search in the same turns."""
    rows = []
    for side, size, fit_target, sample_target, repeats in (
        (128, 200, "60 ms", "3 ms", 21),
        (200, 800, "", "40 ms", 7),
        (512, 512, "1 s", "", 5),
    ):
        pixels = sample_of(side, "leaves")
        works: dict[Any, Work] = {}
        for method in PATCH_METHODS:
            works[method, "fit"] = fitting(pixels, method)
            works[method, "sample"] = sampling(pixels, size, method)
        if side < 512:
            works["exhaustive"] = sampling(pixels, size, search="exhaustive")
        took = medians(works, repeats)
        for method in PATCH_METHODS:
            fast = took[method, "sample"]
            ratio = f"{took['exhaustive'] / fast:.1f} x" if "exhaustive" in took else ""
            rows.append(
                [
                    f"{side} to {size}",
                    method,
                    f"{ms(took[method, 'fit'])}",
                    fit_target,
                    f"{ms(fast)}",
                    sample_target,
                    f"{size**2 / fast / 1e6:.3g}",
                    ratio if method == "patch-sampling" else "",
                    "",
                ]
            )
    for method in PATCH_METHODS:
        for threads in some((1, 2)):
            runs = [child(method=method, size=8192, threads=threads) for _ in some(range(3))]
            took_once = statistics.median(run["sample"] for run in runs)
            rows.append(
                [
                    f"256 to 8192, {threads} thread{'s'[: threads - 1]}",
                    method,
                    ms(statistics.median(run["fit"] for run in runs)),
                    "",
                    ms(took_once),
                    "3.36 s",
                    f"{8192**2 / took_once / 1e6:.3g} (20)",
                    "",
                    f"{max(run['peak'] for run in runs):.0f} MiB (1024)",
                ]
            )
    for side in (128, 512):
        for threads in ("", "1"):
            blas = {"OPENBLAS_NUM_THREADS": threads} if threads else {}
            run = child(blas, side=side, repeats=9)
            what = f"fit {side}, {'one BLAS thread' if threads else 'BLAS as it comes'}"
            rows.append([what, "patch-sampling", ms(run["fit"]), *[""] * 6])
    notes = """
Side of the sample to side of the output, RGB, defaults. Targets are for patch sampling on two
cores. "x" is the time of the exhaustive search for the same over this one; the paper has 70.
"""
    head = ["", "method", "fit", "target", "sample", "target", "megapixels/s", "x", "peak memory"]
    return notes, head, rows


def table1() -> Table:
    """Table I of the paper; see examples/papers/patch_sampling.py."""
    return paper.table1(20)


def copying() -> Table:
    """Verbatim copying; see examples/papers/patch_sampling.py."""
    return paper.copying()


def growth() -> Table:
    """How fit and sample grow with the sizes of the sample, the output and the patch."""
    rows = []
    series: tuple[tuple[str, tuple[int, ...]], ...] = (
        ("sample side", (64, 128, 256, 512, 1024)),
        ("output side", (128, 256, 512, 1024, 2048)),
        ("patch size", (8, 16, 32, 64, 96)),
        ("candidates", (10, 40, 160, 640)),
    )
    for what, values in series:
        works: dict[Any, Work] = {}
        for value in some(values):
            side, size, patch, candidates = 192, 512, 40, 40
            if what == "sample side":
                side, patch = value, min(patch, value // 2)
            elif what == "output side":
                size = value
            elif what == "patch size":
                patch = value
            else:
                candidates = value
            pixels = sample_of(side)
            given: dict[str, Any] = {"patch_size": patch, "candidates": candidates}
            works[value, "fit"] = fitting(pixels, **given)
            works[value, "sample"] = sampling(pixels, size, **given)
        took = medians(works, 5)
        for value in some(values):
            rows.append([what, str(value), ms(took[value, "fit"]), ms(took[value, "sample"])])
    notes = "Otherwise 192 to 512, patches of 40 px, 40 candidates, the default search."
    return notes, ["varied", "to", "fit", "sample"], rows


def recall() -> Table:
    """How near each search comes to the truly nearest windows, and what it costs."""
    searches: list[tuple[str, dict[str, Any]]] = [("exhaustive", {})]
    searches += [
        (search, {"candidates": candidates})
        for search in ("quadtree", "kdtree", "kdtree-pca", "pca")
        for candidates in (10, 40, 160)
    ]
    common = {"patch_size": 32, "boundary_width": 4, "repeat_distance": 0, "epsilon": 0}
    ratios: dict[int, list[float]] = {k: [] for k in range(len(searches))}
    times: dict[int, list[float]] = {k: [] for k in range(len(searches))}
    for name in some(paper.SAMPLES):
        exemplar = weftex.Exemplar(papers.load(name, 128))
        truth = Truth(exemplar)
        works = {}
        for k, (search, given) in enumerate(searches):
            model = weftex.PatchSampling(search=search, **given, **common).fit(exemplar)
            ratios[k] += truth.ratios(model.sample(sized(200), seed=1))
            works[k] = lambda model=model: model.sample(sized(200), seed=1).image
        for k, took in medians(works, 5).items():
            times[k].append(took)
    rows = []
    for k, (search, given) in enumerate(searches):
        ratio = np.array(ratios[k])
        rows.append(
            [
                search,
                str(given.get("candidates", "all")),
                f"{100 * (ratio < 1.0001).mean():.0f} %",
                f"{ratio.mean():.3f}",
                f"{np.quantile(ratio, 0.95):.2f}",
                ms(statistics.mean(times[k])),
            ]
        )
    notes = """
For every patch of a 200x200 output from a 128x128 crop of each packaged sample (epsilon 0, so the
best window found is taken; patches of 32 px, zones of 4): how often it is the truly nearest one,
and its distance over the nearest one's (eq. 2), on average and for the worst twentieth.
"""
    head = ["search", "candidates", "nearest found", "distance ratio", "95 %", "sample"]
    return notes, head, rows


class Truth:
    """Distances of eq. (2) to all windows of a sample, by a matrix product."""

    def __init__(self, exemplar: weftex.Exemplar) -> None:
        self.exemplar = exemplar
        self.pixels = exemplar.pixels.reshape(*exemplar.shape, -1)
        self.windows: dict[bytes, tuple[np.ndarray, np.ndarray]] = {}

    def ratios(self, result: weftex.Synthesis) -> list[float]:
        """Distance of each patch of a result over the least possible at its place."""
        found = []
        for k, (y, x, sy, sx, zone) in enumerate(result.placements.tolist()):
            weight = result.weights[zone]
            mask = (weight > 0) & (weight < 256)
            if not mask.any():
                continue
            before = PatchSynthesis(
                result.canvas,
                result.placements[:k],
                result.weights,
                result.cuts,
                sample_shape=result.sample_shape,
                exemplar=self.exemplar,
            )
            height, width = mask.shape
            part = before.image[y : y + height, x : x + width].reshape(height, width, -1)
            distances = self._distances(part[mask].ravel(), mask)
            chosen = distances[sy, sx]
            found.append(float(max(chosen, 1) / max(distances.min(), 1)) ** 0.5)
        return found

    def _distances(self, query: np.ndarray, mask: np.ndarray) -> np.ndarray:
        key = mask.tobytes()
        if key not in self.windows:
            views = np.lib.stride_tricks.sliding_window_view(self.pixels, mask.shape, (0, 1))
            zones = np.moveaxis(views, 2, -1)[:, :, mask]
            zones = zones.reshape(*zones.shape[:2], -1).astype(np.float64)  # exact sums
            self.windows[key] = zones, (zones**2).sum(axis=2)
        zones, squares = self.windows[key]
        asked = query.astype(np.float64)
        return squares - 2 * (zones @ asked) + asked @ asked


TABLES = (speed, table1, recall, growth, copying)
