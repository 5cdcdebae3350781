"""What `auto` tries beside the rule's choice, and which of the outputs it keeps."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from weftex.canvas import Canvas
from weftex.errors import InvalidInputError
from weftex.exemplar import Exemplar
from weftex.results.synthesis import Synthesis
from weftex.tasks.auto.findings import Findings
from weftex.tasks.auto.rule import WHOLE, Choice, may_place

#: How much lower another score must be: judges agree in three of four cases then.
MARGIN = 1.0
_LARGEST = 2**20  # pixels of an output of which several are made to keep one
_WEAK = 0.3  # confidence from which a lattice is worth a trial


def others(first: Choice, findings: Findings, canvas: Canvas) -> list[Choice]:
    """Return what is tried beside the rule's choice: nothing where the rule is sure."""
    pixels, lattice = canvas.height * canvas.width, findings.lattice
    if pixels > _LARGEST:
        return []
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
