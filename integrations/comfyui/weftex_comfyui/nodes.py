"""The nodes. Each opens a recipe of weftex, and returns what it makes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, ClassVar

import torch

from weftex.errors import InvalidInputError, did_you_mean
from weftex.exemplar.material import Material, read_material
from weftex.io.presets import presets
from weftex.recipe import GRADIENT, LANDMARKS, MATERIAL, PREPARATION, TASKS, Recipe
from weftex.recipe.opening import open_recipe, pictures_like, prepare_material, prepared
from weftex.roles import ROLES
from weftex.tasks.landmarks import remove_landmarks

from . import folders
from .images import batch_of, encoded, has_8_bits, lit, masks_of, materials_of
from .running import progress_of
from .widgets import SEED_INPUT, choice_of_method, fields_of, inputs_of, parameters_of

_ANY, _SET, _RESULT = "IMAGE,WEFTEX_SET", "WEFTEX_SET", "WEFTEX_RESULT"
_SAMPLE = "Images, of which each is a sample of its own, or a set of aligned maps"
_ROLE = {"default": "color", "tooltip": "What the map shows"}


class _Node:
    """What all nodes have."""

    CATEGORY, FUNCTION = "weftex", "run"


class _Making(_Node):
    """A task of weftex.

    `needs` and `takes` are the sockets that must and may be connected: types of ComfyUI and
    tooltips by names. Those of the type `_ANY` are materials, all others pictures.
    """

    RETURN_TYPES = ("IMAGE", _SET, _RESULT)
    RETURN_NAMES = ("image", "set", "result")
    OUTPUT_TOOLTIPS = (
        "The images, or the main map of a set",
        "All maps; those of the first image of a batch",
        "For Replay on Map",
    )
    task = ""
    needs: ClassVar[dict[str, tuple[str, str]]] = {"sample": (_ANY, _SAMPLE)}
    takes: ClassVar[dict[str, tuple[str, str]]] = {}
    of_material: ClassVar[tuple[str, ...]] = ()  # options of `MATERIAL`

    @classmethod
    def options(cls) -> list[Any]:
        """Return the options of the task."""
        return [one for one in TASKS[cls.task].options.values() if not one.local]

    @classmethod
    def INPUT_TYPES(cls) -> dict[str, Any]:
        """Return the inputs in ComfyUI's form."""
        holes = cls.task in ("tile", "fill")
        options = [*cls.options(), *(MATERIAL[name] for name in cls.of_material)]
        return {
            "required": {**_sockets(cls.needs), "seed": SEED_INPUT, **choice_of_method(holes)},
            "optional": {**_sockets(cls.takes), **inputs_of(options)},
        }

    def run(self, seed: int, method: str, parameters: str, **values: Any) -> tuple[Any, ...]:
        """Do the task for each image of the batch, with successive seeds."""
        kinds = {name: kind for name, (kind, _) in {**self.needs, **self.takes}.items()}
        given = {name: values[name] for name in kinds if values.get(name) is not None}
        is_set = isinstance(next(iter(given.values())), Material)
        read = _read(given, kinds)
        count = max(len(read[name]) for name in read if kinds[name] == _ANY)
        method_fields = {"method": method, "parameters": parameters_of(method, parameters)}
        sets, results = [], []
        for number in range(count):
            now = {name: every[min(number, len(every) - 1)] for name, every in read.items()}
            materials = [one for name, one in now.items() if kinds[name] == _ANY]
            fields = self.fields(values, [name for name in now if kinds[name] != _ANY])
            fields |= {**method_fields, "seed": (seed + number) % 2**64}
            made, result = self._make(materials, fields, now, values, progress_of(number, count))
            sets.append(made)
            results.append(result)
        images = [encoded(one) if is_set else one for one in sets]
        return _batch(images), sets[0] if is_set else lit(sets[0]), tuple(results)

    def fields(self, values: Mapping[str, Any], pictures: list[str]) -> dict[str, Any]:
        """Return the options as fields of a recipe; pictures have the names of their sockets."""
        own = {name: name for name in pictures if name in TASKS[self.task].options}
        return fields_of(self.options(), values) | own

    def _make(
        self,
        materials: list[Material],
        fields: dict[str, Any],
        pictures: Mapping[str, Any],
        values: Mapping[str, Any],
        progress: Any,
    ) -> tuple[Material, Any]:
        specs: list[dict[str, Any]] = [{"maps": {"color": "color"}} for _ in materials]
        specs[0] |= fields_of([MATERIAL[name] for name in self.of_material], values)
        if "sample_mask" in pictures:
            specs[0]["mask"] = "sample_mask"
        recipe = Recipe.from_json({"task": self.task, "materials": specs, **fields})
        left = iter(materials)
        opened = open_recipe(
            recipe,
            lambda spec: prepare_material(spec, next(left), pictures.__getitem__),
            pictures.__getitem__,
        )
        result = opened.make(progress=progress)
        first = opened.materials[0]
        pixels = {first.main: result.image, **result.maps}
        made = {k: replace(one, pixels=pixels[k]) for k, one in opened.pictures.items()}
        roles = {first.main: first.roles[first.main], **opened.like.roles}
        return Material(first.name, made, {name: roles[name] for name in made}), result


class Synthesize(_Making):
    """Make more of a material from a sample."""

    TITLE, task = "Synthesize (weftex)", "synth"
    takes: ClassVar = {
        "guide": ("IMAGE", "Image of the output's size that the output follows"),
        "sample_guide": ("IMAGE", TASKS["synth"].options["sample_guide"].help),
        "sample_mask": ("MASK", "White where the sample may be used"),
    }
    of_material = ("repeats", "map_weights", "turn")


class MakeTileable(_Making):
    """Make an image repeat without a seam, at its own size."""

    TITLE, task = "Make Tileable (weftex)", "tile"


class Fill(_Making):
    """Fill the holes in an image."""

    TITLE, task = "Fill (weftex)", "fill"
    takes: ClassVar = {
        "mask": ("MASK", "White where the holes are; else the transparent pixels"),
        "source": (_ANY, "What to fill the holes from, in place of the image itself"),
    }


class Fuse(_Making):
    """Make one image from several materials that merge according to a map."""

    TITLE, task = "Fuse (weftex)", "fuse"
    needs: ClassVar = {f"sample_{number}": (_ANY, _SAMPLE) for number in (1, 2)}
    takes: ClassVar = {
        **{f"sample_{number}": (_ANY, _SAMPLE) for number in (3, 4, 5, 6)},
        "map": ("IMAGE", "Image with one color for each sample; a gradient if not connected"),
    }

    @classmethod
    def options(cls) -> list[Any]:
        """Return the options of the task, and those of gradients."""
        return [*super().options(), *_GRADIENT]

    def fields(self, values: Mapping[str, Any], pictures: list[str]) -> dict[str, Any]:
        """Return the options as fields of a recipe; a gradient is its map."""
        found = super().fields(values, pictures)
        start = len("gradient_")
        gradient = {one.name[start:]: found.pop(one.name) for one in _GRADIENT}
        gradient = {name: value for name, value in gradient.items() if value is not None}
        if "map" in found and gradient:
            raise InvalidInputError(f"gradient_{next(iter(gradient))} has no effect beside a map")
        return {"map": gradient} | found


_GRADIENT = [one._replace(name=f"gradient_{one.name}") for one in GRADIENT.values()]


class Prepare(_Node):
    """Even the light of a photo, straighten it, and remove its landmarks."""

    TITLE = "Prepare (weftex)"
    RETURN_TYPES, RETURN_NAMES = ("IMAGE", _SET), ("image", "set")
    _OPTIONS: ClassVar = [MATERIAL[name] for name in PREPARATION]
    _LANDMARKS: ClassVar = LANDMARKS._replace(
        choices=("keep", "remove"),
        default="keep",
        help="remove: replace recognizable features by the rest of the photo",
    )

    @classmethod
    def INPUT_TYPES(cls) -> dict[str, Any]:
        """Return the inputs in ComfyUI's form."""
        sample = _sockets({"sample": (_ANY, _SAMPLE)})
        return {"required": {**sample, **inputs_of([*cls._OPTIONS, cls._LANDMARKS])}}

    def run(self, sample: Any, landmarks: str, **values: Any) -> tuple[Any, ...]:
        """Prepare each image of the batch."""
        fields = fields_of(self._OPTIONS, values)
        spec = {name: MATERIAL[name].checked(v) for name, v in fields.items() if v is not None}
        made = []
        every = _read({"sample": sample}, {"sample": _ANY})["sample"]
        for number, material in enumerate(every):
            progress_of(number, len(every))(0, 1, "preparing", None)
            material = material if isinstance(sample, Material) else lit(material)
            exemplar = prepared(material.exemplar(), spec)
            if landmarks == "remove":
                exemplar = remove_landmarks(exemplar)
            made.append(replace(material, pictures=pictures_like([material], exemplar)))
        return _batch([encoded(one) for one in made]), made[0]


class ReplayOnMap(_Node):
    """Make the same again from another map of the sample, such as its roughness."""

    TITLE = "Replay on Map (weftex)"
    RETURN_TYPES, RETURN_NAMES = ("IMAGE", _SET), ("image", "set")

    @classmethod
    def INPUT_TYPES(cls) -> dict[str, Any]:
        """Return the inputs in ComfyUI's form."""
        return {
            "required": {
                "result": (_RESULT, {"tooltip": "From the node that made the first map"}),
                "map": (_ANY, {"tooltip": "Image of the sample's size, or a set of such maps"}),
                "role": (list(ROLES), _ROLE),
            }
        }

    def run(self, result: tuple[Any, ...], map: Any, role: str) -> tuple[Any, ...]:
        """Render each result."""
        every = _read({"map": map}, {"map": _ANY}, role)["map"]
        made = []
        for number, one in enumerate(result):
            material = every[min(number, len(every) - 1)]
            pixels = {name: one.render(exemplar) for name, exemplar in material.maps.items()}
            pictures = {k: replace(v, pixels=pixels[k]) for k, v in material.pictures.items()}
            made.append(replace(material, pictures=pictures))
        if isinstance(map, Material):
            return _batch([encoded(one) for one in made]), made[0]
        return _batch(made), lit(made[0])


class LoadSet(_Node):
    """Load a folder of maps from ComfyUI's input folder, or a sample that ships with weftex."""

    TITLE = "Load Set (weftex)"
    RETURN_TYPES, RETURN_NAMES = (_SET, "IMAGE"), ("set", "image")

    @classmethod
    def INPUT_TYPES(cls) -> dict[str, Any]:
        """Return the inputs in ComfyUI's form."""
        about = "Folder below ComfyUI's input folder; names of files say what the maps show"
        return {"required": {"folder": (folders.sets(), {"tooltip": about})}}

    @classmethod
    def IS_CHANGED(cls, folder: str) -> str:
        """Return a text that changes with the files."""
        return folders.state_of(folder)

    def run(self, folder: str) -> tuple[Any, ...]:
        """Read the maps."""
        material = read_material(folders.path_of(folder))
        return material, _batch([encoded(material)])


class SaveSet(_Node):
    """Save all maps, at their own depth, in a new folder below ComfyUI's output folder."""

    TITLE, OUTPUT_NODE = "Save Set (weftex)", True
    RETURN_TYPES: ClassVar[tuple[str, ...]] = ()

    @classmethod
    def INPUT_TYPES(cls) -> dict[str, Any]:
        """Return the inputs in ComfyUI's form."""
        preset = "Engine or program to write the files for; weftex: a file for each map"
        return {
            "required": {
                "set": (_ANY, {"tooltip": "A set, or images, of which each gets a folder"}),
                "filename_prefix": ("STRING", {"default": "weftex/material"}),
                "preset": (["weftex", *sorted(presets().keys() - {"weftex"})], {"tooltip": preset}),
            }
        }

    def run(self, set: Any, filename_prefix: str, preset: str) -> dict[str, Any]:
        """Write the files, and show those that a browser can show."""
        every = _read({"set": set}, {"set": _ANY})["set"]
        every = every if isinstance(set, Material) else [lit(one) for one in every]
        files = [file for one in every for file in folders.save(one, filename_prefix, preset)]
        return {"ui": {"images": [one for one in files if one["filename"].endswith(".png")]}}


class AddMap(_Node):
    """Add an image to a set as one of its maps, or begin a set with it."""

    TITLE = "Add Map to Set (weftex)"
    RETURN_TYPES, RETURN_NAMES = (_SET,), ("set",)

    @classmethod
    def INPUT_TYPES(cls) -> dict[str, Any]:
        """Return the inputs in ComfyUI's form."""
        return {
            "required": {"image": ("IMAGE", {}), "role": (list(ROLES), _ROLE)},
            "optional": {"set": (_SET, {})},
        }

    def run(self, image: torch.Tensor, role: str, set: Material | None = None) -> tuple[Material]:
        """Return a set with the image, in place of a map of the same role."""
        new = lit(materials_of(image, ROLES[role])[0])
        if set is None:
            return (new,)
        kept = [name for name, own in set.roles.items() if own.name != role]
        pictures = {name: set.pictures[name] for name in kept} | dict(new.pictures)
        roles = {name: set.roles[name] for name in kept} | dict(new.roles)
        return (replace(set, pictures=pictures, roles=roles, folder=True),)


class GetMap(_Node):
    """Get one map of a set as an image."""

    TITLE = "Get Map of Set (weftex)"
    RETURN_TYPES, RETURN_NAMES = ("IMAGE",), ("image",)

    @classmethod
    def INPUT_TYPES(cls) -> dict[str, Any]:
        """Return the inputs in ComfyUI's form."""
        return {"required": {"set": (_SET, {}), "role": (list(ROLES), _ROLE)}}

    def run(self, set: Material, role: str) -> tuple[torch.Tensor]:
        """Return the map."""
        names = {own.name: name for name, own in set.roles.items()}
        if role not in names:
            raise InvalidInputError(f"the set has no {role}{did_you_mean(role, names)}")
        shown = encoded(set).pictures[names[role]]
        return (batch_of([shown.pixels]),)


def _sockets(sockets: Mapping[str, tuple[str, str]]) -> dict[str, tuple[str, dict[str, str]]]:
    return {name: (kind, {"tooltip": about}) for name, (kind, about) in sockets.items()}


def _read(
    given: Mapping[str, Any], kinds: Mapping[str, str], role: str = "color"
) -> dict[str, list[Any]]:
    """Return lists of materials and pictures, one for each image of a batch.

    Images have 8 bits where all have, so that those of a task are of one kind.
    """
    images = [value for name, value in given.items() if kinds[name] != "MASK"]
    eight = all(has_8_bits(one) for one in images if not isinstance(one, Material))
    found: dict[str, list[Any]] = {}
    for name, value in given.items():
        if isinstance(value, Material):
            found[name] = [value]
        elif kinds[name] == "MASK":
            found[name] = masks_of(value)
        else:
            found[name] = materials_of(value, ROLES[role], eight=eight)
            if kinds[name] != _ANY:
                found[name] = [one.pictures[one.main] for one in found[name]]
    return found


def _batch(materials: list[Material]) -> torch.Tensor:
    """Return the main maps as a batch of images."""
    return batch_of([one.pictures[one.main].pixels for one in materials])


NODES = (
    LoadSet, Synthesize, MakeTileable, Fill, Fuse, Prepare, ReplayOnMap, AddMap, GetMap, SaveSet,
)  # fmt: skip
