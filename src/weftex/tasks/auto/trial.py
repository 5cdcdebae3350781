"""What `auto` tries beside the rule's choice, and which of the outputs it keeps."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from weftex.analysis.correlation import correlate
from weftex.analysis.lattice import Lattice
from weftex.canvas import Canvas
from weftex.errors import InvalidInputError
from weftex.exemplar import Exemplar
from weftex.naming import make_method, text_of
from weftex.raster.boxes import box_sums
from weftex.results.synthesis import Synthesis
from weftex.tasks.auto.findings import Findings
from weftex.tasks.auto.rule import WHOLE, Choice, may_place

#: How much lower another score must be: judges agree in three of four cases then.
MARGIN = 1.0
_LARGEST = 2**20  # pixels of an output of which several are made to keep one
_WEAK = 0.3  # confidence from which a lattice is worth a trial
#: Pixels of an output up to which blocks on a lattice are refined, which doubles the time.
_REFINED = 2**18
#: Width in pixels of the belts that are refined alone where refinement broke lines.
BELT = 24
#: Pixels a side of the preview that shows whether refinement keeps lines whole.
PREVIEW = 256
#: The share of the correlation of fine detail, one vector on, that refinement must keep. Where thin
#: joints broke it kept 0.8, elsewhere 0.88 to 1.02 (0.72 of irregular bricks, which were whole).
_KEPT = 0.85
_FAINT = 0.1  # correlation below which it says nothing; wires before stones have less


def others(first: Choice, findings: Findings, canvas: Canvas) -> list[Choice]:
    """Return what is tried beside the rule's choice: nothing where the rule is sure."""
    pixels, lattice = canvas.height * canvas.width, findings.lattice
    if pixels > _LARGEST:
        return []
    if first.method == "near-regular" and lattice is not None and lattice.area:
        if pixels > _REFINED:
            return []
        start = text_of(make_method(first.method, first.parameters))
        return [Choice("refinement", {"init": start})]
    if first.method not in ("graphcut", "patch-sampling") or "lattice" in first.parameters:
        return []
    if lattice is None or lattice.confidence < _WEAK or may_place(lattice, findings.shape):
        return []
    vectors = {"lattice": tuple(lattice)} if findings.exact else {}
    stiff = first.method == "graphcut" and findings.exact
    slug, placed = ("graphcut", WHOLE) if stiff else ("near-regular", {})
    return [Choice(slug, {**placed, **vectors})]


def best_of_choices(
    choices: list[Choice], exemplar: Exemplar, make: Callable[[Choice], Synthesis]
) -> tuple[Choice, Synthesis]:
    """Make all outputs and return the first unless another's score is clearly better."""
    best, kept = choices[0], make(choices[0])
    if len(choices) == 1:
        return best, kept
    from weftex.quality.score import Scorer  # most choices need none

    scorer = Scorer(exemplar)
    score = scorer.rate(kept.image).score
    first, tried = score, []
    for choice in choices[1:]:
        if score is None or first is None:
            break
        try:
            made = make(choice)
        except InvalidInputError:
            continue
        other = scorer.rate(made.image).score
        assert other is not None  # of one size, and the first has a score
        tried.append(f"{choice.method} {other:.2f}")
        if other < min(first - MARGIN, score):
            kept, best, score = made, choice, other
    if not tried:
        return best, kept
    scores = ", ".join([f"{choices[0].method} {first:.2f}", *tried])
    because = f"{choices[0].because}; the scores are {scores}"
    return replace(best, because=because, warnings=choices[0].warnings), kept


def refined_if_whole(
    choices: list[Choice],
    lattice: Lattice,
    exemplar: Exemplar,
    preview: Callable[[Choice], Synthesis],
) -> Choice:
    """Return blocks on a lattice, their refinement, or that of their joints, by a preview.

    Refinement hides seams and repairs steps of tone and of joints, but breaks thin lines that its
    coarse levels do not show.
    """
    blocks, refined = choices
    refined = replace(refined, because=blocks.because, warnings=blocks.warnings)
    before = _likeness(preview(blocks), lattice, exemplar)
    if before < _FAINT:
        return blocks
    try:
        left = _likeness(preview(refined), lattice, exemplar) / before
    except InvalidInputError:  # a mask that leaves refinement no window
        return blocks
    if left >= _KEPT:
        return refined
    because = (
        f"{blocks.because}; only the seams between blocks are refined: refining the whole image "
        f"would keep only {max(left, 0):.0%} of its thin lines"
    )
    return replace(refined, parameters=dict(refined.parameters, joints=BELT), because=because)


def _likeness(made: Synthesis, lattice: Lattice, exemplar: Exemplar) -> float:
    """Return the correlation of fine detail with itself one vector on, the mean of both vectors."""
    y, x = np.moveaxis(made.source, -1, 0)
    gray = exemplar.matching().sum(axis=2, dtype=np.int64)[y, x]
    fine = gray[3:-3, 3:-3] - box_sums(gray, 7, 7) / 49
    steps = np.rint(lattice.vectors).astype(int)[:, ::-1]
    down, along = abs(steps).max(axis=0)
    if down >= fine.shape[0] or along >= fine.shape[1]:
        return 0.0
    correlation = correlate(fine[None], reach=(down, along))
    return float(np.mean([correlation[down + v, along + u] for v, u in steps]))
