"""A result: pictures are rendered from the sample pixels that it is made of."""

from __future__ import annotations

import os
from abc import abstractmethod
from collections.abc import Mapping, Set
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from weftex.canvas import Canvas
from weftex.errors import InvalidInputError, UnsupportedError, shown, size_words
from weftex.exemplar import Exemplar, Sample, load_exemplar
from weftex.exemplar.turns import as_copies, as_made_from
from weftex.io.display import Displayable
from weftex.io.npz import one_line_errors
from weftex.raster.mixing import Mixing
from weftex.results import drawing, scales
from weftex.results.cloning import TONE_REACH, join_filling
from weftex.results.joining import EXCLUDED, PastedPieces, join_steps, reach_of, with_mask
from weftex.results.saved import ABOUT, Facts, arrays_of, read_result, write_result
from weftex.results.sources import Place, SourceMap, Window


class Synthesis(Displayable, SourceMap):
    """A result: its image, its maps, and the sample pixels that they come from.

    Functions and models return it. `load` reads one from a file; `from_source` makes one.
    ``np.asarray(result)`` is its image.

    Parameters
    ----------
    canvas : Canvas
        Size, wrapping, and known pixels of the output.
    exemplar : Exemplar or None
        The sample; None after `load` without one.
    sample_shape : (int, int), optional
        Height and width of the sample, if it is None.
    known_from : (int, int), optional
        Position of the canvas in the sample (row, column), if the known pixels are part of it.
    provenance : dict
        Method, parameters, seed, and what else led to the result.
    picture : array, optional
        The finished image, if the method already made it.
    match_tone : bool
        Match the tone of a filled hole to its surroundings.
    tone_reach : float
        Distance in pixels over which steps of tone at seams are spread; 0 copies pixels unchanged.
        Filled holes, images of few colors, normals and colors with alpha are not changed.
    turn, copy_shape : str or None, (int, int) or None
        The copies that `prepare.turned` added to the sample; height and width of one copy.
    parts : uint16 array, optional
        The number of each sample pixel's material (H, W); tones are not spread between materials.
    is_window : bool
        The result is a part of an endless plane, where tone steps are spread within cells only.
    threads : int
        Maximum number of threads of `render`.
    """

    cells: NDArray[np.int64] | None = None  # of a plane, see `PixelSynthesis`

    def __init__(
        self,
        canvas: Canvas,
        *,
        exemplar: Exemplar | None,
        sample_shape: tuple[int, int] | None = None,
        known_from: tuple[int, int] | None = None,
        provenance: dict[str, Any] | None = None,
        picture: NDArray[Any] | None = None,
        match_tone: bool = False,
        tone_reach: float = 0.0,
        is_window: bool = False,
        turn: str | None = None,
        copy_shape: tuple[int, int] | None = None,
        parts: NDArray[np.uint16] | None = None,
        threads: int = 1,
    ) -> None:
        if isinstance(exemplar, Exemplar):
            sample_shape = exemplar.shape
            turn, copy_shape = exemplar.turn or turn, exemplar.copy_shape or copy_shape
        assert sample_shape is not None
        self.canvas, self.sample_shape, self.known_from = canvas, sample_shape, known_from
        excluded = None if exemplar is None or canvas.hole is not None else exemplar.mask
        self.turn, self.copy_shape, self.parts = turn, copy_shape, with_mask(parts, excluded)
        self.exemplar, self.threads = exemplar, threads
        self.provenance, self.tone_reach = provenance or {}, tone_reach
        self._picture, self.match_tone, self.is_window = picture, match_tone, is_window

    def __repr__(self) -> str:
        about = {"method": "by", "seed": "seed"}
        told = [f"{word} {self.provenance[k]}" for k, word in about.items() if k in self.provenance]
        of = "" if self.exemplar is None else f" of {self.exemplar.name!r}"
        size = size_words(self.shape)
        return f"<{type(self).__name__} {size}{of}{': ' if told else ''}{', '.join(told)}>"

    def _displayed_picture(self) -> tuple[NDArray[Any], bool] | None:
        return None if self.exemplar is None else (self.image, self.exemplar.alpha)

    @abstractmethod
    def _lay(self, out: NDArray[Any], pixels: NDArray[Any], window: Window, mixing: Mixing) -> None:
        """Paste the pixels of (H, W, C) over `out`, which is a multiple of the window's size."""

    def moved(self, canvas: Canvas, exemplar: Exemplar, *, to: Place, source_to: Place) -> Self:
        """Return this result as a part, from `to` on, of a larger canvas and a larger sample."""
        arrays: dict[str, Any] = self._moved_arrays(canvas.shape, exemplar.shape, to, source_to)
        return type(self)(
            canvas,
            **arrays,
            exemplar=exemplar,
            known_from=canvas.known_from,
            provenance=self.provenance,
        )

    @property
    def image(self) -> NDArray[Any]:
        """The output: (H, W) or (H, W, C) in the sample's dtype."""
        return self.render() if self._picture is None else self._picture

    @property
    def sample(self) -> Exemplar:
        """The sample; raises `InvalidInputError` after `load` without one."""
        if self.exemplar is None:
            raise InvalidInputError("this result was loaded without its sample; render a map of it")
        return self.exemplar

    @property
    def maps(self) -> Mapping[str, NDArray[Any]]:
        """The sample's maps, replayed at the same coordinates, each when it is asked for."""
        sample = self.sample
        return scales.RenderedMaps(sample.maps, lambda name: self.render(sample.map(name)))

    def render(
        self,
        other: Exemplar | NDArray[Any] | None = None,
        *,
        background: NDArray[Any] | None = None,
        window: Window | None = None,
        role: str | None = None,
    ) -> NDArray[Any]:
        """Make this result from another map or image that is aligned with the sample.

        Parameters
        ----------
        other : Exemplar or array, optional
            The map, of the sample's size or an integer multiple or fraction of it, of uint8,
            uint16, float32 or float64 with any number of channels; by default the sample itself.
            For labels of other dtypes, index them with `source`.
        background : array, optional
            For a hole that was filled from another sample: the same map as `other`, but of the
            photo, in its dtype and channels.
        window : (top, left, height, width), optional
            Render only this part, in output pixels.
        role : str, optional
            What an array shows: "color", "normal", "height", "roughness" or another name that the
            page of file formats lists. Without a role it is blended as plain numbers. An `Exemplar`
            has its own role: give none with it.

        Returns
        -------
        array
            In the dtype of `other`, at its multiple or fraction of the output's size.

        Raises
        ------
        InvalidInputError
            If `other` does not fit the sample, or `background` is needed and missing.

        Examples
        --------
        >>> import numpy as np, weftex
        >>> sample = np.arange(64 * 64 * 3, dtype=np.uint16).reshape(64, 64, 3)
        >>> result = weftex.synthesize(sample, (80, 96), seed=1)
        >>> result.render(np.zeros((128, 128), np.float32)).shape
        (160, 192)
        """
        whole, own = window is None, other is None or other is self.exemplar
        top, left, height, width = self.canvas.check_window(window)
        given = scales.as_rendered(self.sample if other is None else other, role)
        if background is None:
            background = self.canvas.known if own else self.canvas.known_maps.get(given.name)
        shape = scales.shape_of(given, self.sample_shape, self.turn, self.copy_shape)
        ratio = scales.scale_to(given, shape)
        hole = self.canvas.hole
        tones = self.tone_reach if hole is None else TONE_REACH * self.match_tone
        reach = 0.0 if self.is_window and self.cells is None else reach_of(given, tones, hole)
        if hole is not None and reach and not whole:  # what is around must be seen
            made = self.render(given, background=background)
            ends = ((top, top + height), (left, left + width))
            rows, columns = (slice(int(start * ratio), int(end * ratio)) for start, end in ends)
            return made[rows, columns]
        if ratio < 1:
            scales.check_window((top, left, height, width), ratio, given.name)
            return scales.in_few_pixels(
                lambda large, around: self.render(large, background=around, window=window),
                *(given, background, ratio),
            )
        if self.turn is not None and shape == self.copy_shape:
            given = as_copies(given, self.turn, int(ratio))
        scale, pixels, mixing = int(ratio), given.pixels, given.mixing
        base: NDArray[Any] | None = None
        if hole is not None:
            base = scales.background_of(pixels, self.shape, scale, self.known_from, background)

        def lay(part: Window) -> NDArray[Any]:
            top, left, height, width = part
            out = np.empty((height * scale, width * scale, *pixels.shape[2:]), pixels.dtype)
            if base is not None:
                out[:] = base[top * scale :, left * scale :][: height * scale, : width * scale]
            below, planes = (a.reshape(*a.shape[:2], -1) for a in (out, pixels))
            self._lay(below, planes, part, mixing)
            return out

        window = top, left, height, width
        if hole is None or base is None:
            layers, wrap = self._pictured_layers, self.canvas.wrap
            parts, heights = self.parts, given.role.kind == "height"
            if parts is not None:
                parts = np.where(parts == EXCLUDED, parts, 0) if heights else parts
                parts = parts.repeat(scale, 0).repeat(scale, 1)
            about = scale, self.threads, parts, self.cells
            laid = PastedPieces(lay, layers, self.shape, wrap, *about)
            out = join_steps(laid, given, reach, window)
        else:
            out = lay(window)
            known = ~hole[top : top + height, left : left + width]
            known = known.repeat(scale, 0).repeat(scale, 1)  # patches may hang over the hole
            out[known] = base[top * scale :, left * scale :][: len(known), : known.shape[1]][known]
            if reach:
                layers_here = self._pictured_layers(window)
                join_filling(out, given, layers_here, self.canvas, self.known_from, scale, reach)
        if own and whole and self._picture is None:
            self._picture = out
        return out

    def draw(self, what: str = "sources") -> NDArray[np.uint8]:
        """Draw the result itself.

        Parameters
        ----------
        what : {"sources", "seams", "patches"}
            "sources": false colors by source position (red grows to the right, green down).
            "seams": red seams over the gray image. "patches": a color for each copied piece.

        Returns
        -------
        uint8 array (H, W, 3)
        """
        if not isinstance(what, str) or what not in drawing.DRAWINGS:
            known = ", ".join(drawing.DRAWINGS)
            raise InvalidInputError(f"cannot draw {shown(what)}; known: {known}")
        if what == "sources":
            return drawing.draw_sources(self.source, self.copy_shape or self.sample_shape)
        source = self.pictured_source()
        if what == "seams":
            return drawing.draw_seams(drawing.gray_of(self.image), source, self.sample_shape)
        return drawing.draw_pieces(source, self.sample_shape)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the image, or the source map and provenance without pixels.

        Parameters
        ----------
        path : str or path
            A name such as `wall.png` writes the image, as `weftex.write_image` does; `wall.npz`
            the source map, compressed, which `load` reads.

        Raises
        ------
        FileError
            If the file cannot be written, or its suffix is of neither.
        InvalidInputError
            If the format cannot hold the image.
        """
        from weftex.io.formats import FORMATS, suffix_of
        from weftex.io.pictures import check_output, write_image

        check_output(path, suffixes=(".npz", *FORMATS))
        if suffix_of(os.fsdecode(path)) in FORMATS:
            write_image(path, self.image, alpha=self.sample.alpha, icc=self.sample.icc)
            return
        canvas, about = self.canvas, {name: getattr(self, name) for name in ABOUT}
        facts = Facts(shape=self.shape, wrap=canvas.wrap, origin=canvas.origin, **about)
        write_result(path, facts, self.arrays(), canvas.hole)

    def to_pil(self) -> Any:
        """Return the image as a `PIL.Image.Image`.

        Raises
        ------
        UnsupportedError
            If Pillow is not installed.
        InvalidInputError
            If Pillow has no such images: more than 8 bits with more than one channel.
        """
        try:
            from PIL import Image
        except ImportError:
            raise UnsupportedError("to_pil needs the package Pillow") from None
        try:
            return Image.fromarray(self.image)
        except TypeError:
            shape, dtype = self.image.shape, self.image.dtype
            raise InvalidInputError(
                f"Pillow has no {dtype} images of shape {shape}; save('out.tif') keeps them"
            ) from None

    @classmethod
    def from_source(
        cls,
        canvas: Canvas,
        source: NDArray[Any],
        exemplar: Exemplar,
        provenance: dict[str, Any] | None = None,
    ) -> Synthesis:
        """Make a result from the source of each pixel, as a method of your own does.

        Parameters
        ----------
        canvas : Canvas
            Size and wrapping of the output; it has no hole.
        source : int array (H, W, 2)
            Row and column in the sample.
        exemplar : Exemplar
            The sample.
        provenance : dict, optional
            Method, parameters and seed, for people and files.

        Raises
        ------
        InvalidInputError
            If the array has another shape or dtype, a source lies outside the sample, or the canvas
            has a hole.

        Examples
        --------
        >>> import numpy as np, weftex
        >>> sample = weftex.load_exemplar("sample:pebbles")
        >>> upside_down = np.moveaxis(np.indices((64, 64))[:, ::-1], 0, 2)
        >>> result = weftex.Synthesis.from_source(weftex.Canvas(64, 64), upside_down, sample)
        >>> bool((result.image == sample.pixels[:64, :64][::-1]).all())
        True
        """
        if canvas.hole is not None:
            raise InvalidInputError("the canvas has a hole; it must have none")
        found, (height, width) = np.asarray(source), exemplar.shape
        if found.shape != (*canvas.shape, 2) or found.dtype.kind not in "iu":
            raise InvalidInputError(
                f"source is {found.dtype} {found.shape}; it must be integer {(*canvas.shape, 2)}"
            )
        if ((found < 0) | (found >= (height, width))).any():
            raise InvalidInputError(f"source lies outside the sample, which is {width}x{height}")
        index = (found[..., 0] * width + found[..., 1]).astype(np.int32)
        own: dict[str, Any] = {"index": index, "provenance": provenance}
        return kind_with({"index"})(canvas, exemplar=exemplar, **own)

    @classmethod
    def load(
        cls,
        path: str | os.PathLike[str],
        exemplar: Sample | None = None,
        known: NDArray[Any] | None = None,
    ) -> Synthesis:
        """Read what `save` wrote.

        Parameters
        ----------
        path : str or path
            The `.npz` file.
        exemplar : path, array, PIL image or Exemplar, optional
            The sample; `image` and `maps` need it, `render` of another image does not.
        known : array, optional
            The photo around a filled hole; `image` needs it if that is not the sample.

        Raises
        ------
        FileError, InvalidInputError
            If the file is missing, damaged, or something else; if the sample has another size.
        """
        with one_line_errors(path, "a saved weftex result"):
            facts, arrays = read_result(path)
            hole = facts.check_hole(arrays.pop("hole", None))
            kind = kind_with(arrays.keys())
            own = arrays_of({**kind.ARRAYS, **kind.OPTIONAL}, arrays, facts.sample_shape)
            canvas = Canvas(*facts.shape, facts.wrap, hole=hole, origin=facts.origin)
            kind._check(canvas, facts.sample_shape, own)
        if hole is not None:
            canvas = Canvas(*facts.shape, facts.wrap, known, hole)
        sample = None if exemplar is None else as_made_from(load_exemplar(exemplar), facts.turn)
        if sample is not None and sample.shape != facts.sample_shape:
            sizes = (size_words(shape) for shape in (sample.shape, facts.sample_shape))
            raise InvalidInputError("the sample is {}; this result's was {}".format(*sizes))
        about: dict[str, Any] = {name: getattr(facts, name) for name in ABOUT}
        return kind(canvas, exemplar=sample, **own, **about)


def kind_with(arrays: Set[str]) -> type[Synthesis]:
    """Return the kind of result that has these arrays."""
    return next(kind for kind in Synthesis.__subclasses__() if kind.ARRAYS.keys() <= arrays)
