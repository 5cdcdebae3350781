"""Prepare samples: straighten and light photos, estimate maps, rotate copies, join samples.

Most functions take what `weftex.load_exemplar` takes and return an `Exemplar`; functions of
surfaces take and return arrays.
"""

from weftex.exemplar.turns import turned
from weftex.prepare.combining import together
from weftex.prepare.estimating import estimate_maps, light_joints
from weftex.prepare.lighting import even_light
from weftex.prepare.straightening import scaled, straighten
from weftex.prepare.surfaces import height_from_normals, normals_from_height, occlusion_from_height

__all__ = [
    "estimate_maps",
    "even_light",
    "height_from_normals",
    "light_joints",
    "normals_from_height",
    "occlusion_from_height",
    "scaled",
    "straighten",
    "together",
    "turned",
]
