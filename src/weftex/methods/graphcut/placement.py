"""Where patches come from: placement and matching (Kwatra et al., 2003, section 4)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from weftex.methods.graphcut.entire import EntirePatchMatching
from weftex.methods.graphcut.subpatch import SubPatchMatching
from weftex.methods.graphcut.turned import TurnedMatching

if TYPE_CHECKING:
    from weftex.methods.graphcut.places import Placement
    from weftex.methods.graphcut.settings import Settings
    from weftex.methods.pixels.growth import Growth


def placement_of(settings: Settings, growth: Growth) -> Placement:
    """Return the way that `settings.placement` names."""
    if settings.placement == "subpatch":
        return SubPatchMatching(settings, growth)
    if settings.placement == "entire" and settings.exemplar.turn is not None:
        return TurnedMatching(settings, growth)
    return EntirePatchMatching(settings, growth, random=settings.placement == "random")
