"""Make an atlas of corner tiles: an endless texture that does not repeat, for one lookup."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from pathlib import Path
from string import Template
from typing import Any
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

from weftex.analysis.lattice import Lattice
from weftex.canvas import Canvas
from weftex.endless.boxes import A_BLOCK, PlaneRequest, box_of
from weftex.endless.corners import sure_vectors
from weftex.endless.plane import usable_corners
from weftex.endless.tiles import TilePlane, belt_of, size_with_periods, torus
from weftex.errors import InvalidInputError, size_words, whole_pair, wrong_value
from weftex.exemplar import Exemplar, Sample, load_exemplar
from weftex.method import Method
from weftex.naming import is_auto, make_method
from weftex.prepare.landmarks import find_landmarks, has_joint_network
from weftex.progress import ProgressCallback
from weftex.random import Seed, seed_number
from weftex.registry import AUTO
from weftex.results.scales import RenderedMaps
from weftex.results.synthesis import Synthesis
from weftex.tasks.auto.rule import WHOLE
from weftex.threads import thread_count

__all__ = ["Atlas", "atlas", "corner_colors"]

_USUAL, _LEAST = 512, 32  # pixels a side of a tile
#: Colors by which editors show corner colors.
_SHOWN = ((0xD0, 0x43, 0x3B), (0x3B, 0x7D, 0xD0), (0x4C, 0xA8, 0x4C))
#: Tilesets of Tiled and Godot, and a shader. The path in a tileset is relative to its file.
_TEMPLATES = [
    Path(__file__).parent / "presets" / f"corner_tiles{suffix}"
    for suffix in (".tsx", ".tres", ".gdshader")
]
_TIMES = np.array([0x8DA6B343, 0xD8163841, 0xCB1AB31F], np.uint32)
_MIX = np.array([0x7FEB352D, 0x846CA68B], np.uint32)


@dataclass(frozen=True, eq=False)
class Atlas:
    """All corner tiles of a material, in a grid of `colors` squared rows and columns.

    Without a gutter, the grid is a tileable image: all neighboring tiles fit together.

    Attributes
    ----------
    synthesis : Synthesis
        The grid without gutters, with the source of every pixel.
    colors : int
        Number of colors that a corner may have, 2 or 3.
    tile_size : (int, int)
        Height and width of a tile in pixels.
    gutter : int
        Pixels around each tile of `image` and `maps` that continue it.
    notes : tuple of str
        What a user should know, such as a tile size that was changed.
    """

    synthesis: Synthesis
    colors: int
    tile_size: tuple[int, int]
    gutter: int = 0
    notes: tuple[str, ...] = ()

    @property
    def image(self) -> NDArray[Any]:
        """The grid of tiles with their gutters, in the sample's dtype."""
        return self._with_gutters(self.synthesis.image)

    @property
    def maps(self) -> Mapping[str, NDArray[Any]]:
        """The same grid of each map of the sample, rendered on access."""
        maps = self.synthesis.maps
        return RenderedMaps(maps, lambda name: self._with_gutters(maps[name]))

    @property
    def tiles(self) -> NDArray[Any]:
        """The tiles without gutters, (colors**4, height, width) or (…, channels).

        The number of a tile is ``top_left + colors * (top_right + colors * (bottom_left + colors *
        bottom_right))``, by the colors of its corners.
        """
        return self._pieces(self.synthesis.image, self._cells)

    @cached_property
    def _cells(self) -> NDArray[np.int64]:
        """Row and column (colors**4, 2) of each tile in the grid."""
        nodes = torus(self.colors)
        around = np.pad(nodes, (0, 1), mode="wrap")
        order = np.argsort(self._numbers(around), axis=None)
        return np.stack(np.divmod(order, len(nodes)), axis=1)

    @property
    def index(self) -> dict[str, Any]:
        """Sizes of `image`, and position and corner colors of each tile in it, ready for JSON."""
        count, (height, width) = self.colors**2, self.tile_size
        down, across = height + 2 * self.gutter, width + 2 * self.gutter
        tiles = []
        for number, (y, x) in enumerate(self._cells.tolist()):
            at = {"id": y * count + x, "x": x * across + self.gutter, "y": y * down + self.gutter}
            corners = [number // self.colors**k % self.colors for k in range(4)]
            tiles.append(at | {"corners": corners})
        sizes = {"tile_width": width, "tile_height": height, "gutter": self.gutter}
        grid = {"rows": count, "columns": count, "width": count * across, "height": count * down}
        ids = [tile["id"] for tile in tiles]
        return {"colors": self.colors, **grid, **sizes, "ids": ids, "tiles": tiles}

    def documents(self, name: str, image: str, maps: Any = None) -> dict[str, str]:
        """Return index, tilesets and a shader by suffix, for a grid in the file `image`.

        `maps` are lists of the maps in each file, if there are several.
        """
        index = {"image": image} | ({} if maps is None else {"maps": maps}) | self.index
        values = index | {
            "count": len(index["ids"]),
            "numbers": ", ".join(map(str, index["ids"])),
            "spacing": 2 * self.gutter,
            "name_in_xml": quoteattr(name),
            "image_in_xml": quoteattr(image),
            "image_in_quotes": image.replace("\\", "\\\\").replace('"', '\\"'),
            "corners_of_tiled": _corners_of_tiled(index),
            "tiles_of_godot": _tiles_of_godot(index),
            "terrains_of_godot": _terrains_of_godot(self.colors),
        }
        found = {".json": json.dumps(index, indent=1) + "\n"}
        for file in _TEMPLATES:
            found[file.suffix] = Template(file.read_text("utf-8")).substitute(values)
        return found

    def plane(
        self, rows: int, columns: int, seed: int = 0, *, name: str | None = None
    ) -> NDArray[Any]:
        """Return an image of `rows` x `columns` tiles, or of the map `name`.

        Corner colors are those of `corner_colors`, which the samplers for shaders have too.
        """
        pixels = self.synthesis.image if name is None else self.synthesis.maps[name]
        numbers = self._numbers(corner_colors(rows + 1, columns + 1, seed, self.colors))
        found = self._pieces(pixels, self._cells[numbers]).swapaxes(1, 2)
        height, width = found.shape[1], found.shape[3]
        return found.reshape(rows * height, columns * width, *pixels.shape[2:])

    def _numbers(self, nodes: NDArray[np.int64]) -> NDArray[np.int64]:
        """The numbers of the tiles between nodes of these colors."""
        upper = nodes[:, :-1] + self.colors * nodes[:, 1:]
        return upper[:-1] + self.colors**2 * upper[1:]

    def _pieces(self, pixels: NDArray[Any], cells: NDArray[np.int64]) -> NDArray[Any]:
        """The tiles of a grid without gutters at some cells (…, 2)."""
        height, width = (side // self.colors**2 for side in pixels.shape[:2])
        y, x = cells[..., 0, None] * height, cells[..., 1, None] * width
        y, x = y + np.arange(height), x + np.arange(width)
        found: NDArray[Any] = pixels[y[..., :, None], x[..., None, :]]
        return found

    def _with_gutters(self, pixels: NDArray[Any]) -> NDArray[Any]:
        """The same grid of tiles, each with the pixels that surround it."""
        count, lines = self.colors**2, []
        for whole, own in zip(pixels.shape[:2], self.tile_size, strict=True):
            side = whole // count
            gutter = self.gutter * side // own
            around = np.arange(-gutter, side + gutter)
            lines.append((np.arange(count)[:, None] * side + around).ravel() % whole)
        return pixels[np.ix_(*lines)]


def atlas(
    sample: Sample,
    *,
    colors: int = 2,
    tile_size: int | tuple[int, int] | None = None,
    gutter: int = 0,
    method: str | Method = AUTO,
    seed: Seed = None,
    threads: int | None = None,
    progress: ProgressCallback | None = None,
    **parameters: Any,
) -> Atlas:
    """Make all corner tiles of a material.

    Every corner of a tile has one of a few colors. Tiles with the same colors at a side fit
    together without a seam, so random corner colors give an endless texture that does not repeat.
    Salient features of the sample are removed, because they reveal repeats. Samples with a lattice
    or rows, or with joints or cracks that join all sides, are not changed.

    Parameters
    ----------
    sample : path, array, PIL image or Exemplar
        The material. All maps of a set get the same tiles.
    colors : int
        Number of corner colors: 2 makes 16 tiles, 3 makes 81, which repeat less.
    tile_size : int or (int, int), optional
        Height and width of a tile in pixels, 32 or more; by default 512, or the sample's shorter
        side if that is less. With a lattice, such as of bricks, the nearest size with whole
        periods is taken, and `Atlas.notes` says so.
    gutter : int
        Pixels around each tile that continue it, up to half of a tile.
    method : str or Method
        A method that fills holes. By default entire samples are cut by graph cuts, on the sample's
        lattice if it has one.
    seed, threads, progress
        As for `weftex.synthesize`.
    **parameters
        Parameters of the method.

    Returns
    -------
    Atlas

    Raises
    ------
    InvalidInputError
        If an argument is out of range, the sample is too small for the tiles, or no tile size near
        the one asked for contains whole periods of the sample's lattice.
    UnsupportedError
        If the method does not fill holes.
    FileError
        If the sample cannot be read.

    Examples
    --------
    >>> from weftex.atlas import atlas
    >>> made = atlas("sample:pebbles", tile_size=64, seed=7)
    >>> made.image.shape, made.tiles.shape, made.plane(3, 5).shape
    ((256, 256, 3), (16, 64, 64, 3), (192, 320, 3))
    """
    if type(colors) is not int or colors not in (2, 3):
        raise wrong_value("colors", colors, "2 or 3")
    chosen = make_method(method, parameters)
    if not is_auto(chosen):
        chosen.require(A_BLOCK)
    elif chosen != make_method(AUTO, {}):
        raise InvalidInputError("effort has no effect on an atlas")
    exemplar = load_exemplar(sample)
    number, wish = seed_number(seed), _as_size(tile_size, exemplar)
    vectors = getattr(chosen, "lattice", None) or sure_vectors(exemplar)
    if len(vectors) == 2:  # rows
        vectors = tuple(Lattice(((vectors[0], vectors[1]),)))
    size = size_with_periods(vectors, wish, exemplar.name) if vectors else wish
    _check_gutter(gutter, size, exemplar)
    found = 0
    if not vectors and not has_joint_network(exemplar):
        masks, count = find_landmarks(exemplar, others=False)
        if count:
            plain = exemplar.changed(mask=exemplar.usable & ~np.logical_or.reduce(masks))
            if usable_corners(plain, belt_of(size)).any():  # enough is left for corners
                exemplar, found = plain, count
    if is_auto(chosen):
        chosen = make_method("graphcut", WHOLE | ({"lattice": vectors} if vectors else {}))
    else:
        hole = np.pad(np.ones([side - belt_of(size) for side in size], bool), belt_of(size))
        chosen = chosen.for_hole(hole, exemplar.usable, frozenset(parameters))
    model = chosen.fit(exemplar)
    request = PlaneRequest(number, None, thread_count(threads))
    torus_box = box_of(0, 0, *(side * colors**2 for side in size))
    plane = TilePlane(model, request, size, colors, vectors)
    made = plane.window(torus_box, Canvas(*torus_box.shape, (True, True)), progress)
    notes = [f"landmarks removed from the sample: {found}"] if found else []
    if size != wish:
        notes.append(
            f"tiles are {size_words(size)}, not {size_words(wish)}, to contain whole periods "
            "of the sample's lattice"
        )
    return Atlas(made, colors, size, gutter, tuple(notes))


def corner_colors(rows: int, columns: int, seed: int, colors: int) -> NDArray[np.int64]:
    """Return the colors (rows, columns) of the corners of a plane, from (0, 0) on.

    A hash of 32 bits of the corner, which a shader computes as well.

    >>> corner_colors(2, 4, 0, 3).tolist()
    [[0, 2, 1, 2], [1, 0, 1, 1]]
    """
    with np.errstate(over="ignore"):
        y, x = np.ogrid[:rows, :columns]
        bits = x.astype(np.uint32) * _TIMES[0] ^ y.astype(np.uint32) * _TIMES[1]
        bits ^= np.array([seed], np.int64).astype(np.uint32) * _TIMES[2]
        bits = (bits ^ bits >> 16) * _MIX[0]
        bits = (bits ^ bits >> 15) * _MIX[1]
        bits ^= bits >> 16
    found: NDArray[np.int64] = (bits >> 16).astype(np.int64) * colors >> 16
    return found


def _as_size(given: Any, exemplar: Exemplar) -> tuple[int, int]:
    """Height and width of a tile; by default 512, or what the sample has."""
    if given is None:
        given = max(_LEAST, min(_USUAL, *exemplar.shape))
    size = whole_pair(given, _LEAST)
    if size is None:
        wanted = f"a number of pixels, {_LEAST} or more, or a height and a width"
        raise wrong_value("tile_size", given, wanted)
    return size


def _check_gutter(gutter: Any, size: tuple[int, int], exemplar: Exemplar) -> None:
    """Refuse a gutter out of range, and sizes that are no whole pixels of a coarser map."""
    most = min(size) // 2
    if type(gutter) is not int or not 0 <= gutter <= most:
        raise wrong_value("gutter", gutter, f"from 0 to {most}, half of a tile")
    for name in exemplar.maps:
        step = Fraction(exemplar.scale_of(name)).denominator
        if any(pixels % step for pixels in (*size, gutter)):
            raise InvalidInputError(
                f"tile_size is {size_words(size)} and gutter {gutter}; both must be multiples of "
                f"{step}, as map '{name}' has a pixel for {step}x{step} of the sample"
            )


def _corners_of_tiled(index: Mapping[str, Any]) -> str:
    """Return the colors and tiles of a Wang set of corners, for Tiled 1.10 and later.

    A Wang ID lists the colors of top, top right, right and so on around; 0 is none.
    """
    lines = ""
    for number, color in enumerate(_SHOWN[: index["colors"]]):
        shown = f'name="Corner {number}" color="#{bytes(color).hex()}"'
        lines += f'   <wangcolor {shown} tile="-1" probability="1"/>\n'
    for tile in sorted(index["tiles"], key=lambda tile: tile["id"]):
        top_left, top_right, bottom_left, bottom_right = (color + 1 for color in tile["corners"])
        wang = f"0,{top_right},0,{bottom_right},0,{bottom_left},0,{top_left}"
        lines += f'   <wangtile tileid="{tile["id"]}" wangid="{wang}"/>\n'
    return lines


def _tiles_of_godot(index: Mapping[str, Any]) -> str:
    """Return the tiles of a TileSet of Godot 4 with a terrain set that matches corners.

    A tile's own terrain is the color of its top left corner, so that cells painted with any
    terrains have tiles.
    """
    sides, lines = ("top_left", "top_right", "bottom_left", "bottom_right"), ""
    for tile in sorted(index["tiles"], key=lambda tile: tile["id"]):
        row, column = divmod(tile["id"], index["columns"])
        at = f"{column}:{row}/0"
        lines += f"{at} = 0\n{at}/terrain_set = 0\n{at}/terrain = {tile['corners'][0]}\n"
        for side, color in zip(sides, tile["corners"], strict=True):
            lines += f"{at}/terrains_peering_bit/{side}_corner = {color}\n"
    return lines


def _terrains_of_godot(colors: int) -> str:
    """Return the names and colors of the terrains."""
    lines = ""
    for number, color in enumerate(_SHOWN[:colors]):
        shown = ", ".join(str(round(part / 255, 3)) for part in color)
        lines += f'terrain_set_0/terrain_{number}/name = "Corner {number}"\n'
        lines += f"terrain_set_0/terrain_{number}/color = Color({shown}, 1)\n"
    return lines
