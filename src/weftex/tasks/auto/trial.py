"""What `auto` tries beside the rule's choice, and which of the pictures it keeps."""

from __future__ import annotations

from typing import TYPE_CHECKING

from weftex.analysis.canvas_lattice import four_numbers
from weftex.choice import Choice
from weftex.errors import InvalidInputError
from weftex.quality.eye import Eye
from weftex.tasks.auto.rule import WHOLE, is_sure

if TYPE_CHECKING:
    from collections.abc import Callable

    from weftex.canvas import Canvas
    from weftex.exemplar import Exemplar
    from weftex.results.synthesis import Synthesis
    from weftex.tasks.auto.findings import Findings

#: How much better another picture's score must be: an eye agrees in three of four cases then.
MARGIN = 1.0
_LARGEST = 2**20  # pixels of an output of which several are made to keep one
_WEAK = 0.3  # confidence from which a lattice is worth a trial


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
    large = canvas.height * canvas.width > _LARGEST
    if effort == "quick" or large or first.method not in ("graphcut", "patch-sampling"):
        return []
    found, lattice = [], findings.lattice
    if lattice is not None and not is_sure(lattice, findings.shape) and lattice.confidence >= _WEAK:
        vectors = {"lattice": four_numbers(lattice)} if findings.exact else {}
        found.append(Choice("near-regular", vectors))
    if effort == "best":
        found.append(Choice("refinement"))
        found.append(Choice("graphcut", {} if first.parameters == WHOLE else dict(WHOLE)))
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
    eye, kept, best = Eye(exemplar), make(choices[0]), choices[0]
    score = eye.score(kept.image)
    first, tried = score, []
    for choice in choices[1:]:
        if score is None or first is None:
            break
        try:
            made = make(choice)
        except InvalidInputError:
            continue
        other = eye.score(made.image)
        assert other is not None  # of one size, and the first has a score
        tried.append(f"{choice.method} {other:.2f}")
        if other < min(first - MARGIN, score):
            kept, best, score = made, choice, other
    if not tried:
        return best, kept
    head = choices[0].reason.removesuffix(f": {choices[0].method}")
    said = f"{head}, score {first:.2f} (tried {', '.join(tried)}): {best.method}"
    return Choice(best.method, best.parameters, said, choices[0].warnings), kept
