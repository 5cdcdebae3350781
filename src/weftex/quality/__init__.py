"""How good a result is: one file a measure, `assess`, which takes them all, and faults in color."""

from weftex.quality.assess import LARGEST_MEASURED, Assessment, assess, real_crops
from weftex.quality.borders import Border, borders_of, draw_borders
from weftex.quality.faults import as_shown, fault_maps
from weftex.quality.figures import FIGURES, SCORE, Figure

__all__ = [
    "FIGURES",
    "LARGEST_MEASURED",
    "SCORE",
    "Assessment",
    "Border",
    "Figure",
    "as_shown",
    "assess",
    "borders_of",
    "draw_borders",
    "fault_maps",
    "real_crops",
]
