"""What `auto` tries beside the rule's choice, and which of the pictures it keeps."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from weftex.analysis.canvas_lattice import four_numbers
from weftex.choice import Choice
from weftex.errors import InvalidInputError
from weftex.methods import make_method
from weftex.naming import text_of
from weftex.tasks.auto.likeness import detail, like_itself
from weftex.tasks.auto.rule import WHOLE, is_sure, lays_anywhere

if TYPE_CHECKING:
    from collections.abc import Callable

    from weftex.analysis.lattice import Lattice
    from weftex.canvas import Canvas
    from weftex.exemplar import Exemplar
    from weftex.results.synthesis import Synthesis
    from weftex.tasks.auto.findings import Findings

#: How much better another picture's score must be: an eye agrees in three of four cases then.
MARGIN = 1.0
_LARGEST = 2**20  # pixels of an output of which several are made to keep one
_WEAK = 0.3  # confidence from which a lattice is worth a trial
#: Pixels of an output up to which blocks on a lattice are refined, which takes as long as the rest.
_REFINED = 2**18
#: Pixels across the belts that are refined alone where refinement broke lines.
BELT = 24
#: Pixels a side of the preview that says whether refinement keeps lines whole.
PREVIEW = 256
#: How much of the likeness of fine detail, one vector on, refinement must leave. Where thin joints
#: broke it left 0.8, elsewhere 0.88 to 1.02 (but 0.72 of bricks that differ, which were whole).
_KEPT = 0.85
_FAINT = 0.1  # likeness from which it says anything; wires before stones have less


def others(first: Choice, findings: Findings, canvas: Canvas, effort: str) -> list[Choice]:
    """What is tried beside the rule's choice; nothing where the rule is sure.

    A sure lattice is not given up for a score, and the score has nothing to say of drawings.

    Parameters
    ----------
    first : Choice
        See `weftex.tasks.auto.rule.choose`.
    findings : Findings
        What the sample is like.
    canvas : Canvas
        Without known pixels and without a guide.
    effort : {"quick", "normal", "best"}
        Nothing; what is as fast as the choice; or all that may be better.

    Examples
    --------
    >>> from weftex.analysis.evenness import Evenness
    >>> from weftex.canvas import Canvas
    >>> from weftex.tasks.auto.findings import Findings
    >>> from weftex.tasks.auto.rule import choose
    >>> even = Evenness(0.0, 0.0, 0.0, (1.0, 1.0))
    >>> leaves, canvas = Findings((256, 256), None, True, 43.0, 5000, even), Canvas(512, 512)
    >>> [c.method for c in others(choose(leaves, canvas), leaves, canvas, "best")]
    ['refinement', 'graphcut']
    """
    pixels, lattice = canvas.height * canvas.width, findings.lattice
    if effort == "quick" or pixels > _LARGEST:
        return []
    if first.method == "near-regular" and lattice is not None and lattice.area:
        if pixels > _REFINED and effort == "normal":
            return []
        start = text_of(make_method(first.method, first.parameters))
        return [Choice("refinement", {"init": start})]
    if first.method not in ("graphcut", "patch-sampling") or "lattice" in first.parameters:
        return []
    found = []
    if lattice is not None and not is_sure(lattice, findings.shape) and lattice.confidence >= _WEAK:
        vectors = {"lattice": four_numbers(lattice)} if findings.exact else {}
        stiff = first.method == "graphcut" and findings.exact
        slug, placed = ("graphcut", WHOLE) if stiff else ("near-regular", {})
        found.append(Choice(slug, {**placed, **vectors}))
    if effort == "best":
        found.append(Choice("refinement"))
        found.append(Choice("graphcut", {} if lays_anywhere(first) else dict(WHOLE)))
    return found


def best_of_choices(
    choices: list[Choice], exemplar: Exemplar, make: Callable[[Choice], Synthesis]
) -> tuple[Choice, Synthesis]:
    """Make all, and keep the first unless another's score is clearly better.

    Parameters
    ----------
    choices : list of Choice
        The rule's first.
    exemplar : Exemplar
        The sample.
    make : callable
        Makes the output of a choice.

    Returns
    -------
    Choice, Synthesis
        With the scores in its reason.
    """
    from weftex.quality.score import Scorer  # most choices need none

    scorer, kept, best = Scorer(exemplar), make(choices[0]), choices[0]
    score = scorer.score(kept.image)
    first, tried = score, []
    for choice in choices[1:]:
        if score is None or first is None:
            break
        try:
            made = make(choice)
        except InvalidInputError:
            continue
        other = scorer.score(made.image)
        assert other is not None  # of one size, and the first has a score
        tried.append(f"{choice.method} {other:.2f}")
        if other < min(first - MARGIN, score):
            kept, best, score = made, choice, other
    if not tried:
        return best, kept
    head = choices[0].reason.removesuffix(f": {choices[0].method}")
    said = f"{head}, score {first:.2f} (tried {', '.join(tried)}): {best.method}"
    return Choice(best.method, best.parameters, said, choices[0].warnings), kept


def refined_if_whole(
    choices: list[Choice],
    lattice: Lattice,
    exemplar: Exemplar,
    preview: Callable[[Choice], Synthesis],
) -> Choice:
    """Choose blocks on a lattice, their refinement, or that of their joints, by a preview.

    Refinement hides seams and mends steps of tone and of joints, but breaks thin lines where the
    coarse copies that it begins with do not show them.

    Parameters
    ----------
    choices : list of Choice
        Blocks, and their refinement.
    lattice : Lattice
        The sample's, of two vectors.
    exemplar : Exemplar
        The sample.
    preview : callable
        Makes a small output of a choice.

    Returns
    -------
    Choice
        Where lines broke, all but belts along the seams stays; the reason says how much was kept.
    """
    laid, refined = choices
    head = laid.reason.removesuffix(f": {laid.method}")
    before = _likeness(preview(laid), lattice, exemplar)
    if before < _FAINT:
        return laid
    try:
        left = _likeness(preview(refined), lattice, exemplar) / before
    except InvalidInputError:  # a mask that leaves refinement no window
        return laid
    if left < _KEPT:
        said = f"{head}, joints alone, as {left:.2f} of its lines would be left: refinement"
        belts = dict(refined.parameters, joints=BELT)
        return Choice(refined.method, belts, said, laid.warnings)
    return Choice(refined.method, refined.parameters, f"{head}: refinement", laid.warnings)


def _likeness(made: Synthesis, lattice: Lattice, exemplar: Exemplar) -> float:
    """How much fine detail is like that one vector on; its mean over both vectors."""
    y, x = np.moveaxis(made.source, -1, 0)
    fine = detail(exemplar.matching()[y, x])
    return float(np.mean([like_itself(fine, vector) for vector in lattice.vectors]))
