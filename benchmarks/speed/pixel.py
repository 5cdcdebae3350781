"""Methods that choose pixel by pixel: speed beside targets and brute force, and how they grow."""

from __future__ import annotations

import dataclasses
import statistics
from collections.abc import Iterator
from time import process_time
from typing import Any

import numpy as np
from shared import Table, child, fitting, fuse_three, medians, ms, sample_of, sampling, sized, some

import weftex
from weftex.search import picture_kernels
from weftex.search import window_kernels as kernels
from weftex.search.windows import windows_of

_STRIP = 24  # pixels that brute force is timed on


@dataclasses.dataclass(frozen=True)
class Case:
    """One row: what is made of what, and the time that it may take."""

    method: str
    name: str
    side: int
    size: int
    colors: int = 0  # reduce the sample to so many; 0 keeps all
    parameters: dict[str, Any] = dataclasses.field(default_factory=dict)
    target: str = ""  # fit and sample together, or one + the other
    times: str = ""  # the ratio to brute force that is wanted
    paper: str = ""  # seconds there


CASES = (
    Case("exact-matching", "pebbles", 192, 400, 0, {"window_width": 11}, "0.5 s", "100", "4.04"),
    Case("exact-matching", "bricks", 192, 400, 12895, {"window_width": 69}, "5 s", "100", "27"),
    Case("exact-matching", "leaves", 100, 400, 234, {"window_width": 33}, "", "15", "125"),
    Case("exact-matching", "pebbles", 192, 400),
    Case("wei-levoy", "pebbles", 128, 200, 0, {"levels": 3}, "1 s + 0.5 s", "", "22 + 7.5"),
    Case("wei-levoy", "pebbles", 128, 200, 0, {"levels": 3, "search": "full"}),
    Case("wei-levoy", "pebbles", 128, 200),
    Case("efros-leung", "pebbles", 128, 200, 0, {"window_width": 15}, "8 s"),
    Case("ashikhmin", "pebbles", 192, 1000, 0, {}, "1 s"),
    Case("refinement", "pebbles", 192, 200, 0, {}, "3 s", "", "653"),
    Case("refinement", "pebbles", 192, 512, 0, {}, "15 s"),
    Case("refinement", "pebbles", 192, 200, 0, {"search": "nearest"}, "", "", "653"),
    Case("graphcut", "pebbles", 192, 512, 0, {}, "3 s"),
)


def reduced(pixels: np.ndarray, colors: int) -> np.ndarray:
    """The picture in about so many colors.

    Few by Pillow's median cut. Many by joining the colors that are nearest to each other in the
    least bits until there are no more.
    """
    from PIL import Image

    if not colors:
        return pixels
    if colors <= 256:
        image = Image.fromarray(pixels).quantize(colors).convert("RGB")
        return np.asarray(image)
    # Coarser steps for a growing share of the colors, most frequent ones last.
    low, high, best = 0.0, 4.0, pixels
    for _ in range(20):
        step = 2 ** ((low + high) / 2)
        found = np.rint(np.rint(pixels / step) * step).clip(0, 255).astype(np.uint8)
        if distinct(found) > colors:
            low = (low + high) / 2
        else:
            high, best = (low + high) / 2, found
    return best


def distinct(pixels: np.ndarray) -> int:
    """How many colors there are."""
    return len(np.unique(pixels.reshape(-1, pixels.shape[-1]), axis=0))


def sample_for(case: Case) -> np.ndarray:
    return reduced(sample_of(case.side, case.name), case.colors)


def one_search(levels: np.ndarray, width: int, causal: bool) -> float:
    """Seconds that one pixel takes by brute force: all windows of a sample, all their pixels.

    The time of a strip of pixels in the middle of a picture; distances are not weighted, no
    comparison ends early, and choosing from the distances is not counted.
    """
    half = width // 2
    reach = (half, 0, half, half) if causal else (half, half, half, half)
    windows = windows_of(weftex.Exemplar(levels), reach)
    runs = np.zeros(((2 * half + 1) * (half + 2), 3), np.int32)
    done = np.ones((4 * half + 3, 4 * half + 3 + _STRIP), np.uint8)
    canvas = np.resize(levels, (*done.shape, levels.shape[2]))
    query = np.zeros(width * width * levels.shape[2], np.uint8)
    out = np.zeros(windows.centers.size, np.int64)
    times = []
    for x in range(2 * half + 1, 2 * half + 1 + _STRIP):
        start = process_time()
        y = 2 * half + 1
        count = (
            kernels.causal_runs(y, x, done.shape[1], False, half, half, half, runs)
            if causal
            else picture_kernels.known_runs(done, y, x, False, False, half, runs)
        )
        kernels.gather_runs(canvas, y, x, runs, count, query)
        kernels.distances(windows.pixels, windows.centers, runs, count, query, out)
        times.append(process_time() - start)
    return statistics.median(times)


#: Methods whose every choice is that of a nearest window.
BRUTE = ("exact-matching", "wei-levoy", "efros-leung", "ashikhmin")


def brute_force(case: Case, model: Any, size: int) -> float:
    """Seconds that a method would take if it compared every pixel with every window.

    From one search at each level of its pyramid and in each of its passes; a level costs what its
    own causal window and the full one at its parent cost.
    """
    method = model.method
    levels = model.exemplar.matching()
    width: int = method.window_width
    count = getattr(method, "levels", 1)
    if case.method == "efros-leung":  # the known part of a full window, half of it on average
        return size**2 * one_search(levels, width, causal=False) / 2
    total = 0.0
    for level in range(count):
        side = -(-size // 2**level)
        here = np.ascontiguousarray(levels[:: 2**level, :: 2**level])
        total += side**2 * one_search(here, width, causal=True)
        if level + 1 < count:
            parent = np.ascontiguousarray(here[::2, ::2])
            inner = getattr(method, "parent_width", None) or width - 2
            windows = (here.shape[0] * here.shape[1]) / (parent.shape[0] * parent.shape[1])
            total += side**2 * one_search(parent, inner, causal=False) * windows
    if case.method == "ashikhmin":  # passes after the first look at full windows
        total += (method.passes - 1) * size**2 * one_search(levels, width, causal=False)
    return total


def available(cases: tuple[Case, ...]) -> Iterator[Case]:
    """Those whose method and parameters there are."""
    for case in cases:
        if case.method in weftex.METHODS:
            fields = {f.name: f for f in dataclasses.fields(weftex.METHODS[case.method])}
            search = case.parameters.get("search")
            known = set(case.parameters) <= set(fields)
            if known and (not search or search in fields["search"].metadata["choices"]):
                yield case


def pixel(scale: float = 1.0) -> Table:
    """Fit and sample beside targets, the papers' figures and brute force."""
    rows = []
    for case in some(available(CASES)):
        case = dataclasses.replace(
            case, side=max(round(case.side * scale), 80), size=sized(round(case.size * scale))
        )
        pixels = sample_for(case)
        fit = fitting(pixels, case.method, **case.parameters)
        sample = sampling(pixels, case.size, case.method, **case.parameters)
        start = process_time()
        sample()
        once = process_time() - start
        repeats = 7 if once < 1 else 3 if once < 20 else 1
        took = medians({"fit": fit, "sample": sample}, repeats)
        model = fit()
        both = took["fit"] + took["sample"]
        settled = {
            name: getattr(model.method, name, None) for name in ("window_width", "patch_size")
        }
        given = {name: value for name, value in settled.items() if value} | case.parameters
        against = ["", ""]
        if case.method in BRUTE:
            brute = brute_force(case, model, case.size)
            against = [
                ms(brute) if brute < 60 else f"{brute / 60:.3g} min",
                f"{brute / both:.3g} x",
            ]
        rows.append(
            [
                case.method,
                ", ".join(f"{key} {value}" for key, value in given.items()),
                f"{case.name} {pixels.shape[0]} to {case.size}",
                str(distinct(pixels)),
                f"{ms(took['fit'])} + {ms(took['sample'])}",
                case.target,
                f"{case.size**2 / took['sample'] / 1e6:.3g}",
                case.paper,
                *against,
                case.times and f"{case.times} x",
            ]
        )
    notes = f"""
RGB, fit + sample; targets are for both together where they are one. The papers' seconds are theirs,
on machines of 2000 to 2006. Brute force compares every pixel with every whole window of the sample,
by the plain kernel, without early ends or weights: the median time of a strip of {_STRIP} pixels,
times all pixels, levels and passes. "x" is that over fit and sample together.
"""
    head = ["method", "", "", "colors", "seconds", "target", "megapixels/s", "paper, s"]
    return notes, [*head, "brute force", "x", "target"], rows


#: Method, side of the output: the slow one makes less.
GROWING = (("exact-matching", 256), ("wei-levoy", 128), ("ashikhmin", 256), ("efros-leung", 48))


def pixel_growth(scale: float = 1.0) -> Table:
    """How the pixel methods grow with the window, the sample, its colors and the output."""
    series: tuple[tuple[str, tuple[int, ...]], ...] = (
        ("window width", (5, 11, 21, 41)),
        ("sample side", (64, 128, 256, 512)),
        ("colors", (8, 32, 128, 1000, 8000)),
        ("output side, of the first", (1, 2, 4)),
    )
    methods = [(slug, round(size * scale)) for slug, size in GROWING if slug in weftex.METHODS]
    rows = []
    for what, values in series:
        for value in some(values):
            row = [what, str(value)]
            for slug, size in methods:
                side, colors, width = 128, 0, 11
                if what == "window width":
                    width = value
                elif what == "sample side":
                    side = value
                elif what == "colors":
                    colors = value
                else:
                    size *= value
                pixels = reduced(sample_of(side), colors)
                works = {
                    "fit": fitting(pixels, slug, window_width=width),
                    "sample": sampling(pixels, size, slug, window_width=width),
                }
                took = medians(works, 3)
                row.append(f"{ms(took['fit'])} + {ms(took['sample'])}")
            rows.append(row)
    sides = ", ".join(f"{slug} {size}" for slug, size in methods)
    notes = f"""
Fit + sample. Otherwise a window of 11 px, a 128x128 sample with all its {distinct(sample_of(128))}
colors, and an output of this side: {sides}.
"""
    return notes, ["varied", "to", *(slug for slug, _ in methods)], rows


def fusion(scale: float = 1.0) -> Table:
    """Three samples merged where a map says."""
    size = round(400 * scale)
    rows = []
    for method in ("exact-matching", "refinement"):
        took = medians({method: lambda method=method: fuse_three(size, method)}, 3)[method]
        peak = child(method=method, size=size, fuse=True)["peak"]
        rows.append([method, ms(took), "5 s", f"{peak:.0f} MiB", "500 MiB"])
    notes = f"""
`weftex.fuse`, analysis included: pebbles, bricks, leaves of 192x192 in three bands, {size}x{size}.
Memory is that of a process with NumPy and Pillow that does nothing else.
"""
    return notes, ["method", "time", "target", "peak memory", "target"], rows


TABLES = (pixel, pixel_growth, fusion)
