"""From a recipe to a result, or to windows of an endless plane."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from weftex import Exemplar, Synthesis
from weftex.exemplar.material import Material
from weftex.io.pictures import Picture
from weftex.method import Model
from weftex.progress import ProgressCallback
from weftex.recipe import Recipe
from weftex.recipe.opening import OpenedRecipe, open_recipe
from weftex.studio.materials import id_of, load_material, map_of, maps_of, size_of
from weftex.studio.pictures import shown, whole_number
from weftex.studio.refusals import Refusal
from weftex.studio.sessions import Session
from weftex.studio.uploads import label_of, picture_of

#: What `Result.stem` adds; a result of a result has it once.
_ENDS = re.compile(r"(_(filled|fused|tileable|\d+x\d+))+$")


@dataclass(frozen=True)
class Result:
    """A result, and how its pictures are stored."""

    recipe: Recipe  # with its size
    result: Synthesis
    name: str  # of the first material
    folder: bool  # whether it is a set of maps
    # By the maps' names: what the files of the material are like, of which only the pixels differ.
    pictures: dict[str, Picture]
    seconds: float

    @property
    def id(self) -> str:
        """The name of a result: the same for the same recipe."""
        return id_of(self.recipe.as_json())

    @property
    def main(self) -> str:
        """The name of the picture itself among its maps."""
        return next(iter(self.pictures))

    def map(self, name: str | None) -> Exemplar:
        """Return the sample's map of this name, the picture itself by default."""
        return map_of(self.result.sample, self.main, name)

    def pixels(self, name: str | None) -> Any:
        """Return the pixels of a map."""
        own = self.map(name)
        return self.result.image if own is self.result.sample else self.result.render(own)

    @property
    def material(self) -> Material:
        """Its pictures, as a material."""
        names = self.pictures.items()
        pictures = {name: replace(like, pixels=self.pixels(name)) for name, like in names}
        roles = {name: self.map(name).role for name in pictures}
        return Material(self.name, pictures, roles, folder=self.folder)

    @property
    def tileable(self) -> bool:
        """Whether it is tileable along both axes."""
        options = self.recipe.options
        return options.get("tileable") is True or options.get("axes") is True

    @property
    def output(self) -> str:
        """What commands write: a folder for a set."""
        floats = self.pictures[self.main].pixels.dtype.kind == "f"
        return "out/" if self.folder else "out.exr" if floats else "out.png"

    @property
    def stem(self) -> str:
        """The name of exported files without their suffix; never that of the sample itself."""
        recipe, (height, width) = self.recipe, self.result.shape
        tileable = recipe.options.get("tileable") or recipe.task == "tile"
        what = {"fill": "filled", "fuse": "fused"}.get(recipe.task, f"{width}x{height}")
        stem = _ENDS.sub("", os.path.splitext(label_of(self.name))[0])
        return f"{stem}_{'tileable' if tileable and recipe.task != 'fill' else what}"


def bytes_of(result: Synthesis) -> int:
    """Return what a result takes in memory."""
    return int(result.image.nbytes + sum(array.nbytes for array in result.arrays().values()))


def open_job(recipe: Recipe, session: Session) -> OpenedRecipe:
    """Read what a recipe needs, and fill its size in; raise `Refusal` if that is too large."""
    for upload in recipe.pictures:
        session.upload(upload)
    picture = partial(picture_of, session=session)
    job = open_recipe(recipe, partial(load_material, session=session), picture)
    height, width = job.shape
    if recipe.task == "synth":
        job = replace(job, recipe=recipe.changed(size=[height, width]))
    if math.prod(job.shape) > session.limits.output_pixels:
        most = session.limits.output_pixels / 2**20
        raise Refusal(
            413,
            f"size is {width}x{height}; the studio makes at most {most:g} megapixels at once, "
            "weftex on the command line more",
            "size",
        )
    return job


def fitted(job: OpenedRecipe, session: Session, sample: Exemplar) -> Model:
    """Return a recipe's method, fitted to its sample."""
    method, names = job.recipe.method, [id_of(spec) for spec in job.recipe.materials]
    key = "model", *names, method, job.recipe.options["sample_guide"]
    return session.find(lambda: method.fit(sample), lambda _: 8 * size_of(sample), *key)


def make(job: OpenedRecipe, session: Session, progress: ProgressCallback) -> Result:
    """Make what a recipe says."""
    start = perf_counter()
    result = job.make(get_model=partial(fitted, job, session), progress=progress)
    result.image  # rendering is part of the work  # noqa: B018
    seconds, folder = perf_counter() - start, any(one.folder for one in job.materials)
    return Result(job.recipe, result, job.materials[0].name, folder, job.pictures, seconds)


_LARGEST = 1024  # pixels a side of a window
_FAR = 2**40  # pixels from the middle of a plane


@dataclass(frozen=True)
class Plane:
    """A fitted method that makes windows."""

    model: Model
    main: str  # the name of its picture among the maps
    seed: int
    method: str  # the slug of the one that makes the windows, also where `auto` chose it


def begin_plane(given: Any, session: Session) -> dict[str, Any]:
    """Fit the method of a recipe to its material; return the plane as JSON for the page."""
    recipe = Recipe.from_json(given)
    job = open_job(recipe.changed(size=None, tileable=False), session)
    name = id_of({"plane": job.recipe.as_json()})

    def fit() -> Plane:
        model = fitted(job, session, job.sample)
        used = model.window(0, 0, 1, 1, seed=recipe.seed).provenance
        return Plane(model, next(iter(job.pictures)), recipe.seed, used["method"])

    plane = session.find(fit, lambda _: 2**20, "plane", name)
    maps = maps_of(plane.model.exemplar, plane.main)
    return {"id": name, "maps": maps, "method": plane.method}


def plane_window(name: str, query: Mapping[str, str], session: Session) -> NDArray[np.uint8]:
    """Return a window of a plane as a screen shows it, or raise `Refusal`."""
    plane: Plane | None = session.recall("plane", name)
    if plane is None:
        raise Refusal(410, "this endless texture is no longer in memory; open it again")
    top, left = (whole_number(query, side, 0, -_FAR, _FAR) for side in ("top", "left"))
    height, width = (whole_number(query, side, 256, 1, _LARGEST) for side in ("height", "width"))
    like = map_of(plane.model.exemplar, plane.main, query.get("map"))
    box = top, left, height, width
    made = session.find(
        lambda: plane.model.window(*box, seed=plane.seed, threads=1), bytes_of, "window", name, *box
    )
    return shown(like, made.image if like is plane.model.exemplar else made.render(like))
