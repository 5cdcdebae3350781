"""Open the materials of a recipe, and run its task."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

from numpy.typing import NDArray

from weftex.canvas import as_canvas
from weftex.errors import InvalidInputError
from weftex.exemplar import Exemplar
from weftex.exemplar.material import Material, read_material, role_of_picture
from weftex.io.pictures import Picture, mask_of, read_image
from weftex.method import Model
from weftex.progress import ProgressCallback
from weftex.recipe import Recipe, gradient
from weftex.results.scales import check_map_scales
from weftex.results.synthesis import Synthesis
from weftex.roles import COLOR, Role, role_of
from weftex.tasks.synthesize import synthesize_on

OpenPicture = Callable[[str], Picture]

__all__ = ["OpenedRecipe", "PreparedMaterial", "open_recipe", "prepare_material", "read_described"]


class PreparedMaterial(NamedTuple):
    """A material in memory."""

    spec: Mapping[str, Any]  # its description in the recipe
    material: Material  # as its files have it
    exemplar: Exemplar  # prepared as described, without mirrored or rotated copies

    @property
    def sample(self) -> Exemplar:
        """The exemplar with its mirrored and turned copies, if there are to be any."""
        return with_turns(self.exemplar, self.spec)

    @property
    def stored(self) -> Material:
        """The material with the pixels of the exemplar."""
        return replace(self.material, pictures=pictures_like([self.material], self.exemplar))


def read_described(spec: Mapping[str, Any], open_picture: OpenPicture) -> Material:
    """Read the material of a description; a single image is named by its role."""
    if "path" in spec:
        return read_material(spec["path"], spec.get("maps"))
    if "sample" in spec:
        found = read_material(f"sample:{spec['sample']}")
        if found.folder:
            return found
        (picture,), (role,) = found.pictures.values(), found.roles.values()
        return Material(spec["sample"], {role.name: picture}, {role.name: role})
    pictures = {name: open_picture(picture) for name, picture in spec["maps"].items()}
    if len(pictures) == 1:
        ((name, picture),) = pictures.items()
        role = role_of_picture(picture.path) if name == COLOR.name else role_of(name) or Role(name)
        return Material(picture.path, {role.name: picture}, {role.name: role})
    # In the order of a folder that has them.
    order = sorted(pictures, key=lambda name: os.path.splitext(pictures[name].path)[0])
    roles = {name: role_of(name) or Role(name) for name in order}
    pictures = {name: pictures[name] for name in order}
    return Material(spec.get("name") or "material", pictures, roles, folder=True)


def prepare_material(
    spec: Mapping[str, Any], material: Material, open_picture: OpenPicture
) -> PreparedMaterial:
    """Prepare a material as its description says, in the order of `MATERIAL`."""
    exemplar = material.exemplar(tileable=spec.get("repeats", False))
    if "map_weights" in spec:
        exemplar = exemplar.changed(weights=spec["map_weights"])
    if "mask" in spec:
        exemplar = exemplar.changed(mask=_usable(exemplar, spec["mask"], open_picture))
    exemplar = prepared(exemplar, spec, times_of(material, spec))
    return PreparedMaterial(spec, measured(material, spec), exemplar)


def measured(material: Material, spec: Mapping[str, Any]) -> Material:
    """Return a material whose pictures have the density that its description gives them."""
    width, times = spec.get("sample_width"), times_of(material, spec)
    if width is None and times == 1:
        return material
    main = material.pictures[material.main]
    width = width or main.pixels.shape[1] / (main.density or 1)
    pictures = {
        name: replace(one, density=times * one.pixels.shape[1] / width)
        for name, one in material.pictures.items()
    }
    return replace(material, pictures=pictures)


def times_of(material: Material, spec: Mapping[str, Any]) -> float:
    """Return how many times as many pixels a side a material is to have, by its density."""
    if spec.get("density") is None:
        return 1.0
    main, width = material.pictures[material.main], spec.get("sample_width")
    now = main.density if width is None else main.pixels.shape[1] / width
    if now is None:
        raise InvalidInputError(
            f"density is {spec['density']:g} pixels per meter, and {material.name} states none; "
            "give the width of what it shows: --sample-width 0.6m"
        )
    return float(spec["density"] / now)


def prepared(exemplar: Exemplar, spec: Mapping[str, Any], times: float = 1.0) -> Exemplar:
    """Straighten a sample, even its light, and scale it `times`, as its description says."""
    if spec.get("straighten") is not None:
        from weftex.prepare.straightening import straighten

        exemplar = straighten(exemplar, **straighten_arguments(spec["straighten"]))
    if spec.get("even_light") is not None:
        from weftex.prepare.lighting import even_light

        exemplar = even_light(exemplar, spec["even_light"])
    if times != 1:
        from weftex.prepare.straightening import scaled

        exemplar = scaled(exemplar, times)
    return exemplar


def with_turns(exemplar: Exemplar, spec: Mapping[str, Any]) -> Exemplar:
    """Return a sample with its mirrored and turned copies, where its description says so."""
    if spec.get("turn") is None:
        return exemplar
    from weftex.exemplar.turns import turned

    return turned(exemplar, spec["turn"])


def straighten_arguments(text: str) -> dict[str, str]:
    """Return the arguments of `straighten`: vectors, corners, or nothing."""
    return {{4: "lattice", 8: "corners"}[text.count(",") + 1]: text} if text else {}


def _usable(exemplar: Exemplar, mask: str, open_picture: OpenPicture) -> NDArray[Any]:
    """Return what of a sample may be used: white in a picture, or what is opaque."""
    if mask == "alpha":
        from weftex.tasks.fill import transparent

        return ~transparent(exemplar, "--sample-mask")
    picture = open_picture(mask)
    return mask_of(picture.pixels, alpha=picture.alpha)


def open_recipe(
    recipe: Recipe,
    open_material: Callable[[dict[str, Any]], PreparedMaterial] | None = None,
    open_picture: OpenPicture | None = None,
) -> OpenedRecipe:
    """Open the materials of a recipe; without `open_material` and `open_picture`, from files."""
    read_picture = open_picture or read_image

    def read(spec: dict[str, Any]) -> PreparedMaterial:
        return prepare_material(spec, read_described(spec, read_picture), read_picture)

    open_one = open_material or read
    return OpenedRecipe(recipe, tuple(open_one(spec) for spec in recipe.materials), read_picture)


@dataclass(frozen=True)
class OpenedRecipe:
    """A recipe whose materials are in memory."""

    recipe: Recipe
    prepared: tuple[PreparedMaterial, ...]
    open_picture: OpenPicture

    @cached_property
    def _pairs(self) -> tuple[list[Exemplar], list[str]]:
        """The samples with the maps that all have, and notes about maps that are left out."""
        from weftex.prepare.combining import of_one_kind, paired

        samples = of_one_kind([one.exemplar for one in self.prepared])
        return paired(samples, self.recipe.options.get("missing"))

    @property
    def _is_one(self) -> bool:
        return len(self.prepared) == 1 or self.recipe.task in ("tile", "fill")

    @property
    def like(self) -> Exemplar:
        """The sample whose picture and maps the result has."""
        return self.prepared[0].exemplar if self._is_one else self._pairs[0][0]

    @property
    def notes(self) -> list[str]:
        """What was left out of the samples, a line each."""
        return [] if self._is_one else list(self._pairs[1])

    @property
    def materials(self) -> tuple[Material, ...]:
        """The materials whose pictures the result has."""
        return tuple(one.material for one in self.prepared)[: 1 if self._is_one else None]

    @cached_property
    def pictures(self) -> dict[str, Picture]:
        """By the names of maps, pictures like the result's: the main one first."""
        return pictures_like(self.materials, self.like)

    @cached_property
    def sample(self) -> Exemplar:
        """The sample of synth: several as one, with its guide and its turned copies."""
        sample = self.like
        if not self._is_one:
            from weftex.prepare.combining import combined

            sample = combined(self._pairs[0], apart=True)
        if (own := self._guide("sample_guide")) is not None:
            sample = sample.changed(guide=own.pixels)
        return with_turns(sample, self.recipe.materials[0])

    @cached_property
    def hole(self) -> NDArray[Any]:
        """The pixels that fill is to fill, bool (H, W)."""
        from weftex.tasks.fill import hole_of

        mask = self.recipe.options["mask"]
        picture = None if mask == "alpha" else self.open_picture(mask)
        return hole_of(picture, self.prepared[0].exemplar)

    @cached_property
    def shape(self) -> tuple[int, int]:
        """Height and width of the result."""
        if not self.recipe.options.get("fit"):
            return self.asked
        from weftex.tasks.auto import fitting_canvas

        canvas = as_canvas(self.asked, self.recipe.options["tileable"])
        return fitting_canvas(canvas, self.sample, self.recipe.method).shape

    @cached_property
    def asked(self) -> tuple[int, int]:
        """Height and width before `fit`."""
        options = self.recipe.options
        if self.recipe.task in ("tile", "fill"):
            return self.prepared[0].exemplar.shape
        if options.get("window") is not None:
            return tuple(options["window"][2:])
        if options["size"] is not None:
            return tuple(options["size"])
        if self.recipe.task == "fuse":
            return self._label_map.shape[:2]  # type: ignore[no-any-return]
        if (guide := self._guide("guide")) is not None:
            return guide.shape
        height, width = self.like.shape
        return 2 * height, 2 * width

    @cached_property
    def _label_map(self) -> Any:
        """What `weftex.fuse` takes: pixels of a picture, or a gradient."""
        given = self.recipe.options["map"]
        return self.open_picture(given).pixels if isinstance(given, str) else gradient(given)

    def _guide(self, name: str) -> Exemplar | None:
        given = self.recipe.options[name]
        if given is None:
            return None
        picture = self.open_picture(given)
        return Exemplar(picture.pixels, alpha=picture.alpha, name=picture.path)

    def make(
        self,
        *,
        seed: int | None = None,
        get_model: Callable[[Exemplar], Model] | None = None,
        progress: ProgressCallback | None = None,
        threads: int | None = None,
    ) -> Synthesis:
        """Do the task, with another seed if one is given.

        Whoever keeps models of synth gives `get_model`, which returns the model of its sample.
        """
        if self.recipe.task in ("synth", "fuse"):
            check_map_scales(self.like, self.shape)
        how: dict[str, Any] = {"seed": self.recipe.seed if seed is None else seed}
        how |= {"threads": threads, "progress": progress}
        if self.recipe.task == "synth":
            return self._synth(how, get_model or self.recipe.method.fit)
        method = self.recipe.method.slug
        how |= {"method": method, **self.recipe.parameters}  # tasks see which were given
        options = dict(self.recipe.options)
        photo = self.prepared[0].exemplar
        if self.recipe.task == "tile":
            from weftex.tasks.tile import tile

            return tile(photo, **options, **how)
        if self.recipe.task == "fill":
            from weftex.tasks.fill import fill

            del options["mask"]
            sample = self.prepared[1].sample if len(self.prepared) > 1 else None
            return fill(photo, self.hole, sample=sample, **options, **how)
        from weftex.tasks.fuse import fuse

        del options["map"]
        samples = [one.sample for one in self.prepared]
        return fuse(samples, self._label_map, options.pop("size"), **options, **how)

    def _synth(self, how: dict[str, Any], get_model: Callable[[Exemplar], Model]) -> Synthesis:
        options = self.recipe.options
        if options["window"] is not None:
            model = get_model(self.sample)
            return model.window(*options["window"], period=options["period"], **how)
        canvas = as_canvas(self.shape, options["tileable"])
        if (guide := self._guide("guide")) is not None:
            canvas = replace(canvas, guide=guide.pixels)
        how |= {name: options[name] for name in ("best_of", "landmarks")}
        return synthesize_on(canvas, self.sample, self.recipe.method, get_model, **how)


def pictures_like(materials: Sequence[Material], template: Exemplar) -> dict[str, Picture]:
    """Return pictures with the pixels of a sample and its maps, each as the first that has it."""
    pictures = {}
    for name, pixels in {materials[0].main: template.pixels, **template.maps}.items():
        like = next(one.pictures[name] for one in materials if name in one.pictures)
        pictures[name] = replace(like, pixels=pixels)
    return pictures
