"""Measures, choices and comparisons beside their targets; quality against time."""

from __future__ import annotations

import math
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, field
from html import escape
from time import process_time
from typing import Any

from shared import Table, medians, ms, sample_of, sized, some

import weftex
from weftex.naming import make_method
from weftex.registry import AUTO, METHODS
from weftex.tasks.auto import look

NAMES = ("bricks", "stone_wall", "leaves", "grass")
_SIDE, _SIZE = 192, 384  # of the comparison
_MADE = 320  # pixels a side that quality against time is measured on
_SEEDS = (1, 2, 3)
_FAST = 1.0  # seconds up to which more than one seed is tried


def judging() -> Table:
    """How long it takes to measure, to choose and to compare."""
    small, large = sample_of(256, "bricks"), sample_of(256, "leaves")
    made = {
        size: weftex.synthesize(small, sized(size), method="quilting", seed=1)
        for size in (512, 2048)
    }
    for result in made.values():
        _ = result.image, result.source
    samples = [sample_of(256, name) for name in some((*NAMES, "pebbles", "weave", "tiles", "wood"))]
    wide = sample_of(2048, "pebbles")
    took = medians(
        {
            "measures": lambda: weftex.assess(weftex.Exemplar(small), made[512]),
            "pictures": lambda: weftex.assess(weftex.Exemplar(small), made[512].image),
            "large": lambda: weftex.assess(weftex.Exemplar(small), made[2048]),
            "report": lambda: weftex.pages.report(small, made[512]).html(),
            "wide": lambda: look(weftex.Exemplar(wide)),
            "three": lambda: weftex.synthesize(
                large, sized(256), method="quilting", seed=1, best_of=3
            ),
        },
        3,
    )
    choosing = medians({k: lambda s=s: look(weftex.Exemplar(s)) for k, s in enumerate(samples)}, 5)
    start = process_time()
    weftex.pages.compare(sample_of(_SIDE, "pebbles"), sized(_SIZE), seed=1)
    compared = process_time() - start
    named, loaded = processes()
    rows = [
        ["all measures of 512x512, with its source", ms(took["measures"]), "3 s"],
        ["all measures of 512x512, pictures only", ms(took["pictures"]), "3 s"],
        ["all measures of 2048x2048, with its source", ms(took["large"]), ""],
        ["report on 512x512, page included", ms(took["report"]), ""],
        [f"auto, 256x256: median of {len(samples)} samples", _median(choosing.values()), "0.3 s"],
        ["the slowest of them", ms(max(choosing.values())), "0.3 s"],
        ["auto, 2048x2048", ms(took["wide"]), ""],
        ["best of 3, quilting, 256 to 256", ms(took["three"]), ""],
        [f"compare all {len(METHODS)} methods, {_SIDE} to {_SIZE}", ms(compared), "120 s"],
        ["weftex synth, 128 to 200, --method quilting", ms(named["quilting"]), ""],
        ["the same without --method", ms(named[AUTO]), ""],
        ["modules for choosing and measuring that --method quilting loads", str(loaded), "0"],
    ]
    notes = """
Bricks where nothing else is said; `compare` on pebbles, once, with efros-leung's fast search. Whole
processes where a command is named.
"""
    return notes, ["", "", "target"], rows


def _median(found: Any) -> str:
    return ms(statistics.median(found))


def processes() -> tuple[dict[str, float], int]:
    """Seconds of whole processes with and without a method, and what the first loads in vain."""
    with tempfile.TemporaryDirectory() as folder:
        sample = f"{folder}/sample.png"
        weftex.write_image(sample, sample_of(128, "leaves"))
        words = ["synth", sample, "-o", f"{folder}/out.png", "--size", str(sized(200))]
        words += ["--seed", "7"]
        words.append("--quiet")
        command = [sys.executable, "-m", "weftex", *words]
        works = {
            "quilting": [*command, "--method", "quilting"],
            AUTO: command,
        }
        took = medians({k: lambda c=c: subprocess.run(c, check=True) for k, c in works.items()}, 7)
        code = (
            "import sys; from weftex.cli import main\n"
            f"main({[*words, '--method', 'quilting']!r})\n"
            "print(sum(m.startswith(('weftex.quality', 'weftex.tasks.auto',"
            " 'weftex.analysis.lattice'))"
            " for m in sys.modules))"
        )
        done = subprocess.run([sys.executable, "-c", code], stdout=subprocess.PIPE, check=True)
    return took, int(done.stdout)


@dataclass(frozen=True)
class Setting:
    """A method with parameters: one point of the chart."""

    method: str
    parameters: dict[str, Any] = field(default_factory=dict)

    @property
    def title(self) -> str:
        given = ", ".join(f"{k.replace('_', ' ')} {v}" for k, v in self.parameters.items())
        return f"{self.method}, {given}" if given else self.method


SETTINGS = (
    Setting(AUTO),
    Setting("patch-sampling"),
    Setting("patch-sampling", {"candidates": 5}),
    Setting("patch-sampling", {"search": "exhaustive"}),
    Setting("quilting"),
    Setting("quilting", {"candidates": 5}),
    Setting("quilting", {"search": "exhaustive"}),
    Setting("graphcut"),
    Setting("graphcut", {"candidates": 1, "refinements": 0}),
    Setting("graphcut", {"candidates": 12}),
    Setting("near-regular"),
    Setting("near-regular", {"defaults": "paper"}),
    Setting("best-tile"),
    Setting("refinement"),
    Setting("refinement", {"iterations": 2}),
    Setting("refinement", {"joints": 16}),
    Setting("exact-matching"),
    Setting("exact-matching", {"levels": 1}),
    Setting("exact-matching", {"candidates": 50}),
    Setting("ashikhmin"),
    Setting("ashikhmin", {"passes": 1}),
    Setting("ashikhmin", {"passes": 5}),
    Setting("wei-levoy"),
    Setting("wei-levoy", {"leaves": 1}),
    Setting("efros-leung"),
)


def measured(setting: Setting, exemplar: weftex.Exemplar, size: int) -> tuple[float, float]:
    """Seconds of one thread and score, means over seeds; the slow get one."""
    seconds, scores = [], []
    for seed in _SEEDS:
        start = process_time()
        model = make_method(setting.method, setting.parameters).fit(
            weftex.Exemplar(exemplar.pixels, name=exemplar.name)
        )
        made = model.sample(sized(size), seed=seed, threads=1)
        made.image  # rendering is part of the work  # noqa: B018
        seconds.append(process_time() - start)
        scores.append(weftex.assess(exemplar, made).score or 0.0)
        if seconds[0] > _FAST:
            break
    return statistics.median(seconds), statistics.fmean(scores)


def quality_against_time(
    settings: Sequence[Setting] = SETTINGS, side: int = _SIDE, size: int = _MADE
) -> Table:
    """Which method, and which of its settings, gives what for the same seconds."""
    names = some(NAMES)
    samples = [weftex.Exemplar(sample_of(side, name), name=name) for name in names]
    points = []
    for setting in some(settings, least=2):
        found = [measured(setting, sample, size) for sample in samples]
        seconds, scores = zip(*found, strict=True)
        points.append((statistics.fmean(seconds), statistics.fmean(scores), setting, scores))
        print(f"{setting.title}: {points[-1][0]:.3g} s, {points[-1][1]:.2f}", file=sys.stderr)
    points.sort(key=lambda point: point[:2])
    rows, best = [], math.inf
    for seconds, score, setting, scores in points:
        mark = "yes" if score < best else ""
        best = min(best, score)
        rows.append(
            [setting.title, f"{seconds:.3g}", f"{score:.2f}", mark, *(f"{s:.2f}" for s in scores)]
        )
    notes = f"""
Fit and sample with one thread, {side} to {size}, means over four samples; score of
[weftex's measures](../../reference/measures.md#the-score), less is better. Means of
{len(_SEEDS)} seeds up to {_FAST:g} s, one seed above. Best: no faster setting has a better mean
score.
"""
    return notes, ["method", "seconds", "score", "best", *names], rows


# ---------------------------------------------------------------------------------------- chart

_WIDE, _HIGH, _LEFT, _TOP, _RIGHT, _BOTTOM = 960, 600, 56, 24, 190, 48
_LINE = 13  # pixels from one label to the next
_COLORS = ("#1b6ca8", "#c0392b", "#1e8449", "#8e44ad", "#b9770e", "#16a085", "#7f8c8d", "#2c3e50",
           "#d35400", "#ad1457", "#000000")  # fmt: skip


def quality_against_time_chart(rows: Sequence[Sequence[str]]) -> str:
    """Seconds against score as SVG, both logarithmic; lower and further left is better."""
    points = [(row[0], float(row[1]), max(float(row[2]), 0.1), bool(row[3])) for row in rows]
    x = _axis([p[1] for p in points], _LEFT, _WIDE - _RIGHT)
    y = _axis([p[2] for p in points], _HIGH - _BOTTOM, _TOP)
    methods = sorted({title.partition(",")[0] for title, *_ in points})
    size = f'viewBox="0 0 {_WIDE} {_HIGH}" font-family="sans-serif" font-size="11"'
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" {size}>',
        "<title>Score against seconds</title>",
        f'<rect width="{_WIDE}" height="{_HIGH}" fill="white"/>',
    ]
    for value in x.ticks:
        at = x.place(value)
        parts.append(f'<path d="M{at:.1f} {_TOP}V{_HIGH - _BOTTOM}" stroke="#ddd"/>')
        parts.append(_text(at, _HIGH - _BOTTOM + 16, f"{value:g}", "middle"))
    for value in y.ticks:
        at = y.place(value)
        parts.append(f'<path d="M{_LEFT} {at:.1f}H{_WIDE - _RIGHT}" stroke="#ddd"/>')
        parts.append(_text(_LEFT - 6, at + 4, f"{value:g}", "end"))
    parts.append(_text((_LEFT + _WIDE - _RIGHT) / 2, _HIGH - 8, "seconds", "middle"))
    parts.append(_text(_LEFT - 6, _TOP - 8, "score (lower is better)", "start"))
    front = " ".join(f"{x.place(s):.1f},{y.place(v):.1f}" for _, s, v, best in points if best)
    parts.append(f'<polyline points="{front}" fill="none" stroke="#aaa" stroke-dasharray="4 3"/>')
    # Labels give way to points and to each other.
    taken = [(y.place(v) + 4, x.place(s) - 5, x.place(s) + 5) for _, s, v, _ in points]
    for title, seconds, value, best in sorted(points, key=lambda p: -p[2]):
        across, down = x.place(seconds), y.place(value)
        color = _COLORS[methods.index(title.partition(",")[0]) % len(_COLORS)]
        fill = color if best else "white"
        parts.append(
            f'<circle cx="{across:.1f}" cy="{down:.1f}" r="4" fill="{fill}" stroke="{color}" '
            'stroke-width="1.5"/>'
        )
        start, end = across + 8, across + 8 + 5.6 * len(title)
        line = next(
            line
            for step in range(10**4)
            for line in [down + 4 + (step + 1) // 2 * (1 if step % 2 else -1)]
            if all(
                abs(line - at) >= _LINE or start >= to or begin >= end for at, begin, to in taken
            )
        )
        taken.append((line, start, end))
        parts.append(_text(start, line, title, "start", color))
    return "\n".join([*parts, "</svg>", ""])


@dataclass(frozen=True)
class _Axis:
    low: float
    high: float
    start: float
    end: float

    @property
    def ticks(self) -> list[float]:
        powers = range(math.floor(self.low), math.ceil(self.high) + 1)
        values = [step * 10.0**power for power in powers for step in (1, 2, 5)]
        return [v for v in values if self.low <= math.log10(v) <= self.high]

    def place(self, value: float) -> float:
        share = (math.log10(value) - self.low) / (self.high - self.low)
        return self.start + share * (self.end - self.start)


def _axis(values: Sequence[float], start: float, end: float) -> _Axis:
    low, high = math.log10(min(values)), math.log10(max(values))
    return _Axis(low - 0.1, high + 0.1, start, end)


def _text(x: float, y: float, text: str, anchor: str, color: str = "#333") -> str:
    return (
        f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" fill="{color}">{escape(text)}</text>'
    )


TABLES = (judging, quality_against_time)
#: What is drawn of a table's rows beside the page.
CHARTS = {"quality_against_time": quality_against_time_chart}
