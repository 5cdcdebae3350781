"""Samples made ready: photos straightened and evenly lit, maps estimated, samples turned or joined.

Every function takes what `weftex.load_exemplar` takes and returns an `Exemplar`.
"""

from weftex.exemplar.turns import turned
from weftex.prepare.combining import together
from weftex.prepare.estimating import estimate_maps
from weftex.prepare.lighting import even_light
from weftex.prepare.straightening import straighten

__all__ = ["estimate_maps", "even_light", "straighten", "together", "turned"]
