"""The score of a result with all its maps."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from weftex.quality.eye import Eye
from weftex.quality.view import middle
from weftex.raster.levels import resized

if TYPE_CHECKING:
    from weftex.exemplar import Exemplar
    from weftex.results.synthesis import Synthesis

_JUDGED = 1024  # pixels a side of the middle by which a larger output is judged
_DIGITS = 3  # of a score, as in a report


class Eyes:
    """A sample and its maps, prepared to have results scored by all of them.

    The score is a mean of scores. All maps together count as much as the color, which is what they
    do in matching, and each by its weight there; maps of labels do not count.

    Parameters
    ----------
    exemplar : Exemplar

    Examples
    --------
    >>> import weftex
    >>> sample = weftex.load_exemplar("sample:stone_wall")
    >>> eyes, made = Eyes(sample), weftex.synthesize(sample, 200, method="quilting", seed=1)
    >>> own = [Eye(one).score(made.render(one)) for one in (sample, *map(sample.map, sample.maps))]
    >>> abs(eyes.score(made) - (own[0] + sum(own[1:]) / len(own[1:])) / 2) < 0.001
    True
    """

    def __init__(self, exemplar: Exemplar) -> None:
        self._eyes = [(Eye(exemplar), 1.0)]
        for name, weight in exemplar.weights.items():
            one = exemplar.map(name)
            if weight > 0 and one.role.kind != "labels":
                if exemplar.mask is not None:
                    usable = resized(exemplar.mask.astype(np.float32), exemplar.scale_of(name)) == 1
                    if not usable.any():
                        continue
                    one = one.changed(mask=usable)
                self._eyes.append((Eye(one), weight / len(exemplar.maps)))

    def score(self, made: Synthesis) -> float | None:
        """How bad a result looks beside others of this sample; less is better.

        Of more than 1024 pixels a side the middle is looked at.

        Returns
        -------
        float or None
            See `weftex.quality.eye.Eye.score`; None where the color has no score.
        """
        total = weights = 0.0
        for eye, weight in self._eyes:
            own = eye is self._eyes[0][0]
            image = made.image if own else made.render(eye.exemplar)
            shape = min(image.shape[0], _JUDGED), min(image.shape[1], _JUDGED)
            found = eye.score(middle(image, shape))
            if found is not None:
                total, weights = total + weight * found, weights + weight
            elif own:
                return None
        return round(total / weights, _DIGITS)
