"""The widget that `weftex.studio.view` returns, by anywidget."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import anywidget
import numpy as np
import traitlets

from weftex.errors import WeftexError
from weftex.results.drawing import DRAWINGS
from weftex.studio.materials import map_of, maps_of
from weftex.studio.page_files import module, styles, words
from weftex.studio.pictures import packed, smaller, source_of, times_smaller
from weftex.studio.pictures import shown as as_shown

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex import Exemplar, Synthesis


class View(anywidget.AnyWidget):  # type: ignore[misc]
    """Views of a sample, or of a result and its sample."""

    _esm = module()
    _css = styles()
    _words = traitlets.Dict().tag(sync=True)
    _seen = traitlets.Dict().tag(sync=True)
    height = traitlets.Int().tag(sync=True)

    def __init__(self, sample: Exemplar, result: Synthesis | None, *, height: int) -> None:
        self._sample, self._result = sample, result
        own = sample.role.name  # what the picture itself is called beside its maps
        self._main = "picture" if own in sample.maps else own
        super().__init__(_words=words(), _seen=self._told(), height=height)
        self.on_msg(self._answer)

    def _told(self) -> dict[str, Any]:
        """The list of views; their pictures are sent on request."""
        sample, result = self._sample, self._result
        about = {"main": self._main, "maps": maps_of(sample, self._main)}
        seen: dict[str, Any] = {
            "sample": {"id": "sample", "name": str(sample.name), **about},
            "result": None,
            "drawings": [],
        }
        if result is not None:
            method = str(result.provenance.get("method", type(result).__name__))
            seen["result"] = {"id": "result", "method": method, **about}
            seen["drawings"] = list(DRAWINGS)
        return seen

    def _answer(self, _: Any, wanted: dict[str, Any], buffers: Any) -> None:
        """Answer one question of the page, by its number."""
        told: dict[str, Any] = {"number": wanted.get("number")}
        sent: list[bytes] = []
        try:
            if wanted.get("of") == "source":
                told["source"] = self._source(wanted)
            else:
                picture = self._picture(wanted)
                query = {"most": str(wanted.get("most") or ""), "raw": "1"}
                times = times_smaller(query, picture.shape)
                pixels, kind = packed(smaller(picture, times), query)
                height, width = picture.shape[:2]
                shape = kind.get("x-weftex-pixels")
                told |= {"width": width, "height": height, "pixels": shape}
                sent = [pixels]
        except WeftexError as error:
            told["error"] = " ".join(str(error).split())
        self.send(told, sent)

    def _picture(self, wanted: dict[str, Any]) -> NDArray[np.uint8]:
        """A map, or a drawing, as a screen shows it."""
        sample, result = self._sample, self._result
        drawing, name = wanted.get("draw"), wanted.get("map") or self._main
        if drawing is not None and result is not None:
            return np.atleast_3d(result.draw(str(drawing)))
        like = map_of(sample, self._main, name)
        if wanted.get("of") == "materials" or result is None:
            return as_shown(like, like.pixels)
        return as_shown(like, result.image if like is sample else result.render(like))

    def _source(self, wanted: dict[str, Any]) -> list[int] | None:
        """Column and row in the sample of a pixel of the result."""
        if self._result is None:
            return None
        place = {name: str(wanted.get(name)) for name in "xy"}
        row, column = source_of(self._result, place)
        return [column, row] if row >= 0 else None
