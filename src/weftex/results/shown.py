"""How results show themselves."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from weftex.io.shown import Shown

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.exemplar import Exemplar


class ShownResult(Shown):
    """A result in a few words, and as its picture."""

    exemplar: Exemplar | None
    image: Any
    provenance: dict[str, Any]
    shape: Any

    def __repr__(self) -> str:
        about = {"method": "by", "seed": "seed"}
        told = [f"{word} {self.provenance[k]}" for k, word in about.items() if k in self.provenance]
        of = "" if self.exemplar is None else f" of {self.exemplar.name!r}"
        size = f"{self.shape[1]}x{self.shape[0]}"
        return f"<{type(self).__name__} {size}{of}{': ' if told else ''}{', '.join(told)}>"

    def _picture_shown(self) -> tuple[NDArray[Any], bool] | None:
        return None if self.exemplar is None else (self.image, self.exemplar.alpha)
