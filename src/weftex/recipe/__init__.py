"""Tasks, their options, and recipes of jobs.

A `Recipe` is all that a result depends on. It is read from JSON, where everything is checked, and
written as JSON, as a command, or as Python; all of them make the same bytes.

>>> from weftex.recipe import MATERIAL, TASKS, Recipe
>>> recipe = Recipe.from_json({"materials": [{"sample": "bricks", "turn": "flip"}],
...     "size": [60, 80], "method": "quilting", "parameters": {"patch_size": 24}, "seed": 7})
>>> recipe.command()
'weftex synth sample:bricks -o out.png --size 80x60 --turn flip --seed 7 --method quilting \
--patch-size=24'
>>> recipe.make().image.shape
(60, 80, 3)
>>> Recipe.from_json(recipe.as_json()) == recipe
True

`TASKS` has the options of each task, `MATERIAL` what is done to materials before; each `Option`
knows its help, default and range, and how its value is read, checked and written. Parameters of
methods are declared by the methods, and checked by them.

Images have names: paths on the command line, ids of uploads in the studio. `recipe.make` takes
`open_picture` to read images that are no files, and `open_material` to reuse materials: it returns
a `PreparedMaterial`. `open_recipe` opens the materials without making anything, such as to know the
size of the result:

>>> from weftex.recipe.opening import open_recipe
>>> job = open_recipe(recipe.changed(size=None))
>>> job.shape, list(job.pictures)
((512, 512), ['color'])

Who works on this machine may also name paths and windows: `Recipe.from_json(..., local=True)`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from weftex.recipe.declared import (
    ATLAS,
    CROP,
    GRADIENT,
    LANDMARKS,
    MATERIAL,
    PAD,
    PREPARATION,
    SEED,
    TASKS,
)
from weftex.recipe.fields import FIELDS, Fields, checked_material, pictures_of

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from weftex.io.pictures import Picture
    from weftex.method import Model
    from weftex.progress import ProgressCallback
    from weftex.recipe.opening import PreparedMaterial
    from weftex.results.synthesis import Synthesis

__all__ = [
    "ATLAS",
    "CROP",
    "FIELDS",
    "GRADIENT",
    "LANDMARKS",
    "MATERIAL",
    "PAD",
    "PREPARATION",
    "SEED",
    "TASKS",
    "Recipe",
    "checked_material",
    "pictures_of",
]


class Recipe(Fields):
    """What to make, which can be made, and written as commands and as Python."""

    def command(self, output: str = "out.png", names: Mapping[str, str] | None = None) -> str:
        """Return the commands that make the same; empty if the command line cannot say it.

        An `output` that ends with a slash is a folder; `names` are other names of the pictures.
        """
        from weftex.recipe.command_line import command_of

        return command_of(self, output, names or {})

    def python(self, output: str = "out.png", names: Mapping[str, str] | None = None) -> str:
        """Return a script that makes the same; the arguments are those of `command`."""
        from weftex.recipe.script import python_of

        return python_of(self, output, names or {})

    def make(
        self,
        *,
        open_material: Callable[[dict[str, Any]], PreparedMaterial] | None = None,
        open_picture: Callable[[str], Picture] | None = None,
        get_model: Callable[[Any], Model] | None = None,
        progress: ProgressCallback | None = None,
        threads: int | None = None,
    ) -> Synthesis:
        """Open the recipe and make it: see `weftex.recipe.opening`."""
        from weftex.recipe.opening import open_recipe

        found = open_recipe(self, open_material, open_picture)
        return found.make(get_model=get_model, progress=progress, threads=threads)
