"""The answer to the question which sample pixel goes where; pictures are rendered from it."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.canvas import Canvas
from weftex.errors import InvalidInputError
from weftex.exemplar import Exemplar, check_pixels

if TYPE_CHECKING:
    import os

    from numpy.typing import NDArray

    #: (top, left, height, width) in output pixels.
    Window = tuple[int, int, int, int]

_BAND = 256


class Synthesis:
    """Which pixels of the sample an output is made of.

    This is what all results have in common; `PatchSynthesis` keeps patches and `PixelSynthesis`
    one source a pixel. A result takes little more memory than its picture, and can be replayed on
    any map that is aligned with the sample.

    Parameters
    ----------
    canvas : Canvas
        What was made.
    sample_shape : (int, int)
        Height and width of the sample.
    exemplar : Exemplar, optional
        The sample; not there after `load` without one.
    known_from : (int, int), optional
        Where in the sample the canvas's known pixels are, when it is the same picture.
    provenance : dict
        Method, parameters and seed.
    picture : array, optional
        The finished picture, when making it was part of the work.
    """

    def __init__(
        self,
        canvas: Canvas,
        *,
        sample_shape: tuple[int, int],
        exemplar: Exemplar | None,
        known_from: tuple[int, int] | None = None,
        provenance: dict[str, Any] | None = None,
        picture: NDArray[Any] | None = None,
    ) -> None:
        self.canvas, self.exemplar = canvas, exemplar
        self.sample_shape, self.known_from = sample_shape, known_from
        self.provenance = provenance or {}
        if picture is not None:
            self.__dict__["image"] = picture

    def _layers(self, window: Window) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
        """Coordinates and weights as `layers` returns them, -1 and 0 for known pixels."""
        raise TypeError(f"{type(self).__name__} does not define _layers")

    def _lay(self, out: NDArray[Any], pixels: NDArray[Any], window: Window, alpha: bool) -> None:
        """Lay the pixels of (H, W, C) over `out`, which is a multiple of the window's size."""
        raise TypeError(f"{type(self).__name__} does not define _lay")

    def _error(self) -> NDArray[np.int16]:
        """How far, in grey levels, what was laid is from what its neighbours wanted."""
        raise TypeError(f"{type(self).__name__} does not define _error")

    def moved(
        self,
        canvas: Canvas,
        exemplar: Exemplar,
        *,
        to: tuple[int, int],
        source_to: tuple[int, int],
        provenance: dict[str, Any],
    ) -> Synthesis:
        """Return the same as a part of a larger canvas, made from a part of a larger sample.

        Parameters
        ----------
        canvas, exemplar
            The larger ones.
        to, source_to : (int, int)
            Where the corners of this canvas and of this sample lie in them; both go around.
        provenance : dict
            Of the new result.
        """
        raise TypeError(f"{type(self).__name__} does not define moved")

    def arrays(self) -> dict[str, NDArray[Any]]:
        """What `save` writes, by the name of the parameter."""
        raise TypeError(f"{type(self).__name__} does not define arrays")

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width of the output."""
        return self.canvas.shape

    @cached_property
    def image(self) -> NDArray[Any]:
        """The output: (H, W) or (H, W, C) in the sample's dtype."""
        if self.exemplar is None:
            raise InvalidInputError("this result was loaded without its sample; render a map of it")
        return self.render(self.exemplar)

    @property
    def maps(self) -> dict[str, NDArray[Any]]:
        """The sample's maps, replayed at the same coordinates."""
        if self.exemplar is None:
            raise InvalidInputError("this result was loaded without its sample; render its maps")
        return {name: self.render(pixels) for name, pixels in self.exemplar.maps.items()}

    @property
    def source(self) -> NDArray[np.int32]:
        """Where each pixel comes from: (H, W, 2), row and column in the sample.

        Where patches are mixed, the one with the largest share; -1 for a known pixel that is not
        in the sample.
        """
        result = np.empty((*self.shape, 2), np.int32)
        for top in range(0, self.shape[0], _BAND):
            rows = min(_BAND, self.shape[0] - top)
            result[top : top + rows] = self.layers((top, 0, rows, self.shape[1]))[0][:, :, 0]
        return result

    def layers(self, window: Window | None = None) -> tuple[NDArray[Any], NDArray[Any]]:
        """Coordinates and weights of everything that shows in a window.

        Parameters
        ----------
        window : (top, left, height, width), optional
            In output pixels; the whole output by default.

        Returns
        -------
        coordinates : int32 array (h, w, layers, 2)
            Row and column in the sample, heaviest layer first; -1 where there is none. Up to four
            layers where patches are mixed, one where pixels are copied.
        shares : float32 array (h, w, layers)
            Sum to 1, or are 0 for a known pixel that is not in the sample.
        """
        window = self._check_window(window)
        coordinates, share = self._layers(window)
        if self.known_from is not None and self.canvas.hole is not None:
            top, left, height, width = window
            known = ~self.canvas.hole[top : top + height, left : left + width]
            own = np.indices((height, width)).transpose(1, 2, 0) + (top, left) + self.known_from
            coordinates[known, 0] = own[known]
            share[known, 0] = 1
        return coordinates, share

    def render(
        self,
        other: Exemplar | NDArray[Any] | None = None,
        *,
        background: NDArray[Any] | None = None,
        window: Window | None = None,
    ) -> NDArray[Any]:
        """Make the same from the pixels of another picture that is aligned with the sample.

        Parameters
        ----------
        other : Exemplar or array, optional
            Of the sample's size or an integer multiple of it, any dtype and channel count; the
            sample itself by default.
        background : array, optional
            For a filled hole whose surroundings are not part of the sample: the same surroundings
            in `other`'s kind.
        window : (top, left, height, width), optional
            Render only this part, in output pixels.

        Returns
        -------
        array
            In the dtype of `other`, at its multiple of the output's size.

        Raises
        ------
        InvalidInputError
            If `other` does not fit the sample, or known pixels have nothing to come from.

        Examples
        --------
        >>> import numpy as np, weftex
        >>> sample = np.arange(64 * 64 * 3, dtype=np.uint16).reshape(64, 64, 3)
        >>> result = weftex.synthesize(sample, (80, 96), seed=1)
        >>> result.render(np.zeros((128, 128), np.float32)).shape
        (160, 192)
        """
        whole = window is None
        top, left, height, width = self._check_window(window)
        own = other is None or other is self.exemplar
        given = self.exemplar if other is None else other
        if given is None:
            raise InvalidInputError("this result was loaded without its sample; give a map of it")
        if isinstance(given, Exemplar):
            pixels, alpha = given.pixels, given.alpha
        else:
            pixels = check_pixels(given, "map")
            alpha = pixels.ndim == 3 and pixels.shape[2] in (2, 4)
        scale = pixels.shape[0] // self.sample_shape[0]
        if pixels.shape[:2] != (
            scale * self.sample_shape[0],
            scale * self.sample_shape[1],
        ):
            raise InvalidInputError(
                f"map is {pixels.shape[1]}x{pixels.shape[0]}; it must be the sample's "
                f"{self.sample_shape[1]}x{self.sample_shape[0]} or an integer multiple of it"
            )
        out = np.empty((height * scale, width * scale, *pixels.shape[2:]), pixels.dtype)
        if self.canvas.hole is not None:
            base = self._base(pixels, scale, own, background)
            rows = slice(top * scale, (top + height) * scale)
            out[:] = base[rows, left * scale : (left + width) * scale]
        self._lay(
            out.reshape(*out.shape[:2], -1),
            pixels.reshape(*pixels.shape[:2], -1),
            (top, left, height, width),
            alpha,
        )
        if own and whole:
            self.__dict__.setdefault("image", out)
        return out

    def _base(
        self,
        pixels: NDArray[Any],
        scale: int,
        own: bool,
        background: NDArray[Any] | None,
    ) -> NDArray[Any]:
        """What is under the patches where pixels were known."""
        size = (self.shape[0] * scale, self.shape[1] * scale)
        if background is not None:
            background = check_pixels(background, "background")
        elif own and self.canvas.known is not None:
            background = self.canvas.known
        elif self.known_from is not None:
            y, x = (k * scale for k in self.known_from)
            background = pixels[y : y + size[0], x : x + size[1]]
        else:
            raise InvalidInputError(
                "the known pixels are not part of the sample; give their map as background"
            )
        if background.shape != (*size, *pixels.shape[2:]) or background.dtype != pixels.dtype:
            raise InvalidInputError(
                f"background is {background.shape} {background.dtype}; it must be "
                f"{(*size, *pixels.shape[2:])} {pixels.dtype}"
            )
        return background

    def _check_window(self, window: Window | None) -> Window:
        if window is None:
            return (0, 0, *self.shape)
        top, left, height, width = window
        if min(top, left) < 0 or min(height, width) < 1:
            raise InvalidInputError(f"window is {window}; it must be inside the output")
        if top + height > self.shape[0] or left + width > self.shape[1]:
            raise InvalidInputError(
                f"window {window} leaves the output, which is {self.shape[0]} high "
                f"and {self.shape[1]} wide"
            )
        return window

    def draw(self, what: str = "sources") -> NDArray[np.uint8]:
        """Draw the result itself.

        Parameters
        ----------
        what : {"sources", "seams", "error", "patches", "uncertainty"}
            False colours by source position (red to the right, green downwards); the picture's
            seams in red over its grey version; or how much overlapping patches differ, or a copied
            pixel from what its upper and left neighbours' sources go on with, black for not at
            all; or as `weftex.results.drawing.draw_pieces` and `draw_uncertainty` do.

        Returns
        -------
        uint8 array (H, W, 3)
        """
        if what == "sources":
            scale = 255 / np.maximum(np.array(self.sample_shape) - 1, 1)
            source = self.source
            colour = np.full((*self.shape, 3), 96, np.uint8)
            colour[..., 1::-1] = np.rint(np.maximum(source, 0) * scale)
            colour[source[..., 0] < 0] = 0
            return colour
        if what in ("patches", "uncertainty"):
            from weftex.results.drawing import draw_pieces, draw_uncertainty

            return draw_pieces(self) if what == "patches" else draw_uncertainty(self)
        if what not in ("seams", "error"):
            known = "sources, seams, error, patches, uncertainty"
            raise InvalidInputError(f"cannot draw {what!r}; known: {known}")
        picture = grey_of(self.image)
        if what == "seams":
            y, x = np.indices(self.shape)
            shift = (self.source - np.stack([y, x], axis=-1)) % self.sample_shape
            seam = np.zeros(self.shape, bool)
            seam[1:] |= (shift[1:] != shift[:-1]).any(axis=-1)
            seam[:, 1:] |= (shift[:, 1:] != shift[:, :-1]).any(axis=-1)
            colour = np.repeat(picture[..., None], 3, axis=2)
            colour[seam] = (255, 0, 0)
            return colour
        error: NDArray[np.uint8] = np.clip(self._error(), 0, 255).astype(np.uint8)
        return np.repeat(error[..., None], 3, axis=2)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write everything but the pictures to a compressed `.npz` file."""
        from weftex.results.files import write_result

        write_result(path, self)

    @classmethod
    def load(
        cls,
        path: str | os.PathLike[str],
        exemplar: Exemplar | None = None,
        known: NDArray[Any] | None = None,
    ) -> Synthesis:
        """Read what `save` wrote.

        Parameters
        ----------
        path : str or path
            The `.npz` file.
        exemplar : Exemplar, optional
            The sample, if `image` is wanted.
        known : array, optional
            The surroundings of a filled hole, likewise.

        Raises
        ------
        FileError
            If the file is missing, damaged, or something else.
        """
        from weftex.results.files import read_result

        return read_result(path, exemplar, known)


def grey_of(pixels: NDArray[Any]) -> NDArray[np.uint8]:
    """Mean of the colour channels as bytes; other depths are stretched."""
    levels = pixels.reshape(*pixels.shape[:2], -1)
    if levels.shape[2] in (2, 4):
        levels = levels[..., :-1]
    grey = levels.mean(axis=2)
    if pixels.dtype != np.uint8:
        low, high = float(grey.min()), float(grey.max())
        grey = (grey - low) * (255 / ((high - low) or 1))
    result: NDArray[np.uint8] = np.rint(grey).astype(np.uint8)
    return result
