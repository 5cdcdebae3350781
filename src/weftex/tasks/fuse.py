"""Texture fusion: one picture of several materials, where a map says (section 4)."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from weftex.analysis.scale import structure_scale
from weftex.canvas import Canvas, as_canvas
from weftex.errors import InvalidInputError, did_you_mean, is_whole, shown, size_words, wrong_value
from weftex.exemplar import Exemplar, Sample, load_exemplar
from weftex.label_maps import Gradient, labels_of, map_picture
from weftex.method import Method
from weftex.naming import is_auto, make_method, method_for_task
from weftex.prepare.combining import combined, of_one_kind, paired
from weftex.progress import ProgressCallback, listening
from weftex.random import Seed, seed_number
from weftex.registry import AUTO, FOR_FUSION
from weftex.results.pixels import PixelSynthesis
from weftex.results.saved import in_common
from weftex.tasks.fusion import Fusion, Material

#: How boundaries are made.
BOUNDARIES = ("cut", "merged")


def fuse(
    samples: Sequence[Sample],
    label_map: Any,
    size: int | tuple[int, int] | None = None,
    *,
    colors: Sequence[Any] | None = None,
    mixed: Mapping[Any, tuple[int, int]] | None = None,
    missing: Mapping[str, float | str] | None = None,
    boundary: str = "cut",
    belt_width: int | None = None,
    method: str | Method = AUTO,
    seed: Seed = None,
    tileable: bool | str = False,
    threads: int | None = None,
    progress: ProgressCallback | None = None,
    **parameters: Any,
) -> PixelSynthesis:
    """Synthesize one image of several materials, arranged by a label map.

    Each region of the map is synthesized from its sample, and a little beyond its border. So two
    materials overlap in a belt. A minimum cut places their boundary where it shows least.

    Parameters
    ----------
    samples : sequence of path, array, PIL image or Exemplar
        Two or more, of one dtype, all with alpha or none. Gray samples become color if another has
        color. Maps are paired by role.
    label_map : path, array, PIL image, Gradient or "gradient"
        An image with one color for each sample, or an integer array (H, W) of labels from 0, or a
        `weftex.label_maps.Gradient`: a transition from one sample to the next. "gradient" is
        ``Gradient()``, from the top to the bottom.
    size : int or (int, int), optional
        Height and width of the output. By default the label map's; a gradient needs a size.
    colors : sequence of colors, optional
        The label map's color of each sample. By default, colors belong to the samples in the order
        in which they appear, row by row from the upper left corner.
    missing : mapping of str to float or "flat", optional
        Values, from 0 to 1, of maps for samples that lack them; a normal map is flat. By default
        maps that not all samples have are left out, and `provenance` says so.
    mixed : mapping of color to (int, int), optional
        Further colors, or labels, of regions that merge two samples, with their indices from 0.
    boundary : {"cut", "merged"}
        "cut" only cuts. "merged" also fills a strip along each cut with a mixture of both
        materials, as in the paper. It is half as wide as the larger of their windows.
    belt_width : int, optional
        Width in pixels of the belt in which a boundary may move, half of it on each side of the
        painted line. By default half the larger window of its materials; less where narrow.
    method : str or Method
        "auto": each material is made by the method that suits its sample (see `Auto`); mixed
        regions, and samples below 32 px, by `refinement`, as all is if `parameters` are given. Or
        a method that can fuse, by its name in `weftex.METHODS` or with its parameters.
    seed : int, numpy Generator or None
        The same seed gives the same bytes, with any number of threads.
    tileable : bool or {"x", "y"}
        Axes along which the output and the label map wrap around without a seam.
    threads : int, optional
        Maximum number of threads; one for each processor by default.
    progress : callable, optional
        See `weftex.progress.ProgressCallback`.
    **parameters
        Parameters of the method.

    Returns
    -------
    Synthesis
        The result. Its `sample` holds all samples, one below the other.

    Raises
    ------
    InvalidInputError
        If dtypes or channels differ, a color has no sample or a sample no color, the label map
        has another size, or a value is out of range.
    UnsupportedError
        If the method cannot fuse.
    FileError
        If a file cannot be read.
    CancelledError
        If `progress` returned False.

    Examples
    --------
    >>> import numpy as np, weftex
    >>> labels = np.repeat([[0], [1]], 40, axis=0) * np.ones((1, 90), int)
    >>> weftex.fuse(["sample:pebbles", "sample:leaves"], labels, seed=7).image.shape
    (80, 90, 3)
    """
    number = seed_number(seed)
    if boundary not in BOUNDARIES:
        raise InvalidInputError(
            f"boundary is {shown(boundary)}{did_you_mean(str(boundary), BOUNDARIES)}"
        )
    of_belts: dict[str, Any] = {}
    by_auto = is_auto(method) and not parameters
    chosen = method_for_task("fuse", FOR_FUSION, method, {})
    if boundary == "merged":
        chosen, of_belts = split_parameters(chosen, parameters, as_canvas(1, tileable))
    else:
        chosen = make_method(chosen, parameters)

    def belt_method(width: int) -> Method:
        return chosen.for_belt(width, **of_belts)

    belt_method(chosen.window_for(1))  # refuses what it does not take
    if belt_width is not None and not is_whole(belt_width, 2):
        raise wrong_value("belt_width", belt_width, "an integer of 2 or more")
    with listening(progress):
        exemplars, notes = paired(of_one_kind(_load(samples)), missing)
        widths = [structure_scale(exemplar).window_width for exemplar in exemplars]
    labels, materials = _labels(label_map, size, widths, (colors, mixed), number)
    shape = labels.shape[0], labels.shape[1]
    if belt_width is not None and belt_width > max(shape):
        raise InvalidInputError(
            f"belt_width is {belt_width}; it must be at most {max(shape)}, the canvas's longer side"
        )
    canvas = as_canvas(shape, tileable)
    chosen.require_kind("many")
    chosen.require(canvas)
    whole = combined(exemplars)
    half = None if belt_width is None else belt_width // 2
    belts = belt_method if boundary == "merged" else None
    how = {"threads": threads, "progress": progress}
    fusion = Fusion(whole, exemplars, widths, chosen, by_auto, canvas, number, half, belts, how)
    about = {"seed": number, "samples": [e.name for e in exemplars], "boundary": boundary}
    with listening(progress):
        index = fusion.run(labels, materials)
    notes += [note for one in fusion.told for note in one.pop("warnings")]
    used = in_common(fusion.told) if fusion.told else chosen.describe() | of_belts
    about |= {"warnings": notes} if notes else {}
    part = np.arange(len(exemplars), dtype=np.uint16).repeat([e.shape[0] for e in exemplars])
    return PixelSynthesis(
        canvas,
        index,
        exemplar=whole,
        provenance=used | about,
        tone_reach=max((one.get("tone_reach", 0.0) for one in fusion.told), default=0.0),
        parts=np.broadcast_to(part[:, None], whole.shape),
    )


def split_parameters(
    method: Method, parameters: Mapping[str, Any], canvas: Canvas
) -> tuple[Method, dict[str, Any]]:
    """Return the method of the regions, and the parameters that only belts take."""
    defaults = {f.name: f.default for f in dataclasses.fields(method)}
    both = {name: getattr(method, name) for name in method.belt_parameters} | {**parameters}
    of_belts = {name: both[name] for name in method.belt_parameters}
    regions = make_method(method, both | {name: defaults[name] for name in of_belts})
    taken = {k: v for k, v in of_belts.items() if regions.takes(k, canvas)}
    alone = {k: v for k, v in of_belts.items() if k not in taken and v != defaults[k]}
    return make_method(regions, taken), alone


def _load(samples: Any) -> list[Exemplar]:
    """Return the samples; errors name the number of the sample."""
    if not isinstance(samples, (list, tuple)):
        raise InvalidInputError(f"samples is {shown(samples)}; give a list of two or more samples")
    if len(samples) < 2:
        raise InvalidInputError(f"{len(samples)} sample to fuse; give two or more")
    loaded = []
    for number, sample in enumerate(samples, 1):
        if sample is None:
            raise InvalidInputError(f"sample {number} is None; give an image")
        named: dict[str, Any] = {}
        if isinstance(sample, np.ndarray):
            named["name"] = f"array {number}"
        loaded.append(load_exemplar(sample, **named))
    return loaded


def _labels(
    label_map: Any,
    size: int | tuple[int, int] | None,
    window_widths: list[int],
    named: tuple[Sequence[Any] | None, Mapping[Any, tuple[int, int]] | None],
    seed: int,
) -> tuple[NDArray[np.int32], list[Material]]:
    """Return labels of materials, and the materials: the samples first, then mixed ones."""
    count, (colors, mixed) = len(window_widths), named
    wanted = None if size is None else as_canvas(size).shape
    single: list[Material] = [(k,) for k in range(count)]
    if isinstance(label_map, str) and label_map == "gradient":
        label_map = Gradient()
    if isinstance(label_map, Gradient):
        if wanted is None:
            raise InvalidInputError("a gradient needs the size of the output")
        if colors is not None or mixed:
            raise InvalidInputError("a gradient has no colors; leave colors and mixed out")
        labels, pairs = label_map.label_map(wanted, [width // 2 for width in window_widths], seed)
        return labels, [*single, *pairs]
    if colors is not None and not isinstance(colors, (list, tuple, range)):
        raise wrong_value("colors", colors, "a list of colors")
    if mixed is not None and not isinstance(mixed, Mapping):
        raise wrong_value("mixed", mixed, "a mapping of color to two numbers")
    mixed = mixed or {}
    for key, pair in mixed.items():
        pairing = isinstance(pair, Sequence) and len(pair) == 2
        if not pairing or pair[0] == pair[1] or not all(k in range(count) for k in pair):
            numbers = f"two numbers of samples, 0 to {count - 1}"
            raise wrong_value(f"mixed[{shown(key)}]", pair, numbers)
    picture = map_picture(label_map)
    if colors is None and picture.ndim == 2 and np.isin(picture, [*range(count), *mixed]).all():
        colors = range(count)
    if colors is None and mixed:
        raise InvalidInputError("give the colors of the samples beside those of mixed regions")
    given = None if colors is None else [*colors, *mixed]
    labels = labels_of(picture, count + len(mixed), given)
    if wanted is not None and labels.shape != wanted:
        raise InvalidInputError(
            f"the label map is {size_words(labels.shape)}, the size {size_words(wanted)}; "
            "leave size out, or scale the label map (nearest neighbor)"
        )
    return labels, [*single, *((min(pair), max(pair)) for pair in mixed.values())]
