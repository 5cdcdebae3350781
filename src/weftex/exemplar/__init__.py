"""Samples: files, folders of maps and arrays become an `Exemplar`.

Read it in this order: `material` (what can be given, and how files become pixels and maps),
`exemplar` (what a sample holds); `turns` makes a sample of mirrored and rotated copies.
"""

from typing import TYPE_CHECKING

from weftex.exemplar.exemplar import Exemplar
from weftex.exemplar.material import load_exemplar

if TYPE_CHECKING:
    from weftex.exemplar.material import Sample as Sample

__all__ = ["Exemplar", "load_exemplar"]
