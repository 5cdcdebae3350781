"""Tasks, their options, and recipes of jobs.

A `Recipe` is all that a result depends on. It is read from JSON, where everything is checked, and
written as JSON, as a command, or as Python; all of them make the same bytes.

>>> from weftex.recipe import MATERIAL, TASKS, Recipe
>>> from weftex.recipe.command_line import command_of
>>> recipe = Recipe.from_json({"materials": [{"sample": "bricks", "turn": "flip"}],
...     "size": [60, 80], "method": "quilting", "parameters": {"patch_size": 24}, "seed": 7})
>>> command_of(recipe)
'weftex synth sample:bricks -o out.png --size 80x60 --turn flip --seed 7 --method quilting \
--patch-size=24'
>>> Recipe.from_json(recipe.as_json()) == recipe
True

`TASKS` has the options of each task, `MATERIAL` what is done to materials before; each `Option`
knows its help, default and range, and how its value is read, checked and written. Parameters of
methods are declared by the methods, and checked by them.

`open_recipe` reads the materials; then the size of the result is known, and it can be made:

>>> from weftex.recipe.opening import open_recipe
>>> job = open_recipe(recipe)
>>> job.shape, list(job.pictures)
((60, 80), ['color'])
>>> job.make().image.shape
(60, 80, 3)

Images have names: paths on the command line, ids of uploads in the studio. `open_recipe` takes
`open_picture` to read images that are no files, and `open_material` to reuse materials.

Who works on this machine may also name paths and windows: `Recipe.from_json(..., local=True)`.
"""

from __future__ import annotations

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
from weftex.recipe.recipe import FIELDS, Recipe, checked_material, pictures_of

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
