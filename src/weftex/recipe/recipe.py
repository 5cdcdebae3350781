"""Recipes: all that a result depends on. The same recipe makes the same bytes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from weftex.recipe.fields import Fields

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from weftex.io.pictures import Picture
    from weftex.method import Model
    from weftex.progress import ProgressCallback
    from weftex.recipe.opening import PreparedMaterial
    from weftex.results.synthesis import Synthesis


class Recipe(Fields):
    """What to make, which can be made, and written as commands and as Python."""

    def command(self, output: str = "out.png", names: Mapping[str, str] | None = None) -> str:
        """Return the commands that make the same; empty if the command line cannot say it.

        An `output` that ends with a slash is a folder; `names` are other names of the pictures.
        """
        from weftex.recipe.words import command_of

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
        fit: Callable[[Any], Model] | None = None,
        progress: ProgressCallback | None = None,
        threads: int | None = None,
    ) -> Synthesis:
        """Open the recipe and make it: see `weftex.recipe.opening`."""
        from weftex.recipe.opening import open_recipe

        found = open_recipe(self, open_material, open_picture)
        return found.make(fit=fit, progress=progress, threads=threads)
