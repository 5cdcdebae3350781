"""How good a result is: one file a measure, `assess`, which takes them all, and faults in color."""

from weftex.quality.assess import LARGEST_MEASURED, Assessment, assess, real_crops
from weftex.quality.faults import as_shown, borders_of, borders_of_each, draw_borders, fault_maps
from weftex.quality.figures import FIGURES, SCORE, Figure

__all__ = [
    "FIGURES",
    "LARGEST_MEASURED",
    "SCORE",
    "Assessment",
    "Figure",
    "as_shown",
    "assess",
    "borders_of",
    "borders_of_each",
    "draw_borders",
    "fault_maps",
    "real_crops",
]
