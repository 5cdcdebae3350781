"""From a recipe to a result, by the library's own tasks."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import weftex
from weftex.canvas import as_canvas
from weftex.errors import InvalidInputError
from weftex.io.pictures import mask_of
from weftex.results.scales import check_size
from weftex.studio import materials
from weftex.studio.materials import Loaded, map_of, size_of
from weftex.studio.recipes import fields_of_gradient
from weftex.studio.refusals import Refusal
from weftex.studio.uploads import picture_of

if TYPE_CHECKING:
    from weftex import Exemplar, Synthesis
    from weftex.io.pictures import Picture
    from weftex.material import Material
    from weftex.method import Model
    from weftex.progress import ProgressCallback
    from weftex.studio.recipes import Recipe
    from weftex.studio.sessions import Session


@dataclass(frozen=True)
class Made:
    """A result, and how its pictures are stored."""

    recipe: Recipe  # with its size
    result: Synthesis
    main: str  # the name of the picture among its maps
    # By the maps' names: what the files of the material are like, of which only the pixels differ.
    pictures: dict[str, Picture]
    materials: tuple[Material, ...]
    seconds: float = 0.0  # that it took

    def map(self, name: str | None) -> Exemplar:
        """Return the sample's map of this name, the picture itself by default."""
        return map_of(self.result.sample, self.main, name)

    def pixels(self, name: str | None) -> Any:
        """Return the pixels of a map."""
        own = self.map(name)
        return self.result.image if own is self.result.sample else self.result.render(own)

    @property
    def bytes(self) -> int:
        """What it takes in memory."""
        arrays = sum(array.nbytes for array in self.result.arrays().values())
        return int(self.result.image.nbytes + arrays)


def fitted(recipe: Recipe, session: Session) -> tuple[list[Loaded], Model]:
    """Return a recipe's materials, and its method fitted to them."""
    loaded = [materials.load(spec, session) for spec in recipe.materials]

    def fit() -> tuple[Model, int]:
        exemplar = _sample(loaded)
        return recipe.method.fit(exemplar), 8 * size_of(exemplar)

    model: Model = session.find(fit, "model", *(one.id for one in loaded), recipe.method)
    return loaded, model


def sized(recipe: Recipe, session: Session) -> Recipe:
    """Return a recipe with the size of what it makes, or raise `Refusal`."""
    options = recipe.options
    if recipe.task in ("tile", "fill"):
        size = materials.load(recipe.materials[0], session).exemplar.shape
    elif options["size"] is not None:
        size = options["size"]
    elif recipe.task == "fuse" and isinstance(options["map"], str):
        size = picture_of(options["map"], session).pixels.shape[:2]
    elif recipe.task == "fuse":
        raise InvalidInputError("size is missing; a gradient needs one")
    elif options["guide"] is not None:
        size = picture_of(options["guide"], session).pixels.shape[:2]
    else:
        sample = materials.load(recipe.materials[0], session).exemplar
        size = sample.shape[0] * 2, sample.shape[1] * 2
    if math.prod(size) > session.limits.output_pixels:
        most = session.limits.output_pixels / 2**20
        line = f"size is {size[1]}x{size[0]}; the studio makes at most {most:g} megapixels at"
        raise Refusal(413, f"{line} once, weftex on the command line more", "size")
    if "size" in options and options["size"] is None:
        return recipe.changed(size=list(size))
    return recipe


def make(recipe: Recipe, session: Session, progress: ProgressCallback) -> Made:
    """Make what a recipe says."""
    how: dict[str, Any] = {"seed": recipe.seed, "progress": progress}
    task = {"synth": _synth, "tile": _tile, "fill": _fill, "fuse": _fuse}
    return task[recipe.task](recipe, session, how)


def _synth(recipe: Recipe, session: Session, how: dict[str, Any]) -> Made:
    options = recipe.options
    canvas = as_canvas(options["size"], options["tileable"])
    guide, own, several = (options[k] for k in ("guide", "sample_guide", "best_of"))
    if guide is None:
        recipe.method.require(canvas)
    if guide is None and own is None and several == 1:
        loaded, model = fitted(recipe, session)
        check_size(model.exemplar, canvas.shape)
        return _made(recipe, model.sample(canvas, **how), loaded)
    loaded = [materials.load(spec, session) for spec in recipe.materials]
    sample = _sample(loaded)
    check_size(sample, canvas.shape)
    guides: dict[str, Any] = {
        "guide": None if guide is None else _exemplar(picture_of(guide, session)),
        "sample_guide": None if own is None else _exemplar(picture_of(own, session)),
    }
    made = weftex.synthesize(sample, canvas, method=recipe.method, best_of=several, **guides, **how)
    return _made(recipe, made, loaded)


def _tile(recipe: Recipe, session: Session, how: dict[str, Any]) -> Made:
    loaded = materials.load(recipe.materials[0], session)
    made = weftex.tile(loaded.sample, **recipe.options, **_method(recipe), **how)
    return _made(recipe, made, [loaded])


def _fill(recipe: Recipe, session: Session, how: dict[str, Any]) -> Made:
    loaded = [materials.load(spec, session) for spec in recipe.materials]
    photo, options = loaded[0].exemplar, dict(recipe.options)
    mask = options.pop("mask")
    hole: Any = None if mask == "alpha" else picture_of(mask, session)
    if hole is not None:
        hole = mask_of(hole.pixels, alpha=hole.alpha)
    sample = loaded[1].sample if len(loaded) > 1 else None
    made = weftex.fill(photo, hole, sample=sample, **options, **_method(recipe), **how)
    return _made(recipe, made, loaded[:1])


def _fuse(recipe: Recipe, session: Session, how: dict[str, Any]) -> Made:
    options = dict(recipe.options)
    given, colors = options.pop("map"), options.pop("colors")
    label_map: Any
    if given is None:
        raise InvalidInputError("map is missing; paint one, or take a gradient")
    if isinstance(given, str):
        label_map = picture_of(given, session).pixels
    else:
        label_map = weftex.Gradient(**fields_of_gradient(given))
    if colors is not None:
        options["colors"] = [tuple(one) if isinstance(one, list) else one for one in colors]
    loaded = [materials.load(spec, session) for spec in recipe.materials]
    samples = [one.sample for one in loaded]
    made = weftex.fuse(samples, label_map, method=recipe.method, **options, **how)
    return _made(recipe, made, loaded)


def _method(recipe: Recipe) -> dict[str, Any]:
    """The method by its name, so that tasks see which parameters were chosen."""
    asked = recipe.as_json()
    return {"method": asked["method"], **asked["parameters"]}


def _sample(loaded: list[Loaded]) -> Exemplar:
    """One sample of all materials, as the command line makes it of several photos."""
    if len(loaded) == 1:
        return loaded[0].sample
    for one in loaded:
        for name in ("mask", "map_weights", "repeats", "turn"):
            if name in one.spec:
                raise InvalidInputError(f"{name} needs one material, not several")
    return weftex.together([one.exemplar for one in loaded])


def _exemplar(picture: Picture) -> Exemplar:
    from weftex.material import Material
    from weftex.roles import COLOR

    return Material(picture.path, {"color": picture}, {"color": COLOR}).exemplar()


def _made(recipe: Recipe, result: Synthesis, loaded: list[Loaded]) -> Made:
    """A result with what its pictures are stored like: the first material that has each."""
    result.image  # rendering is part of the work  # noqa: B018
    own = [one.material for one in loaded]
    main, sample = own[0].main, result.sample
    pictures = {}
    for name, one in {main: sample, **{k: sample.map(k) for k in sample.maps}}.items():
        like = next(m.pictures[name] for m in own if name in m.pictures)
        pictures[name] = replace(like, pixels=one.pixels)
    return Made(recipe, result, main, pictures, tuple(own))
