"""Samples: files, folders of maps and arrays become an `Exemplar`.

Read it in this order: `material` (what can be given, and how files become pixels and maps),
`exemplar` (what a sample holds); `turns` makes a sample of mirrored and rotated copies.
"""

from weftex.exemplar.exemplar import Exemplar
from weftex.exemplar.material import Sample as Sample
from weftex.exemplar.material import load_exemplar

__all__ = ["Exemplar", "load_exemplar"]
