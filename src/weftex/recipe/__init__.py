"""What a job is made of, in one place: its tasks, their options, and recipes of jobs.

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

from weftex.recipe.declared import GRADIENT, MATERIAL, PREPARATION, SEED, TASKS
from weftex.recipe.fields import FIELDS, checked_material, pictures_of
from weftex.recipe.recipe import Recipe

__all__ = [
    "FIELDS",
    "GRADIENT",
    "MATERIAL",
    "PREPARATION",
    "SEED",
    "TASKS",
    "Recipe",
    "checked_material",
    "pictures_of",
]
