"""Results: which sample pixels an output is made of; drawn, saved and replayed from that."""

from weftex.results.patches import PatchSynthesis
from weftex.results.pixels import PixelSynthesis
from weftex.results.synthesis import Synthesis

# Loading a file needs to know every kind.
__all__ = ["PatchSynthesis", "PixelSynthesis", "Synthesis"]
