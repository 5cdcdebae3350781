"""The operators of the sidebar.

Each prepares a recipe in the main thread, makes it in a thread of its own, and turns the result
into new images in the main thread again, as one step of undo. Called by a script, without a
window, an operator waits for the result.
"""

from __future__ import annotations

import os
import re
from typing import Any

import bpy

from weftex.errors import InvalidInputError, WeftexError
from weftex.recipe import Recipe
from weftex.recipe.opening import open_recipe
from weftex.roles import role_of

from . import images, materials
from .jobs import Job
from .settings import PROPERTIES, fields_of

_TICK = 0.1  # seconds between two looks at a job


class _Making:
    """What all operators share: a job, its progress in the status bar, and Esc to cancel it."""

    bl_options = frozenset({"REGISTER", "UNDO"})
    task = "synth"

    def prepare(self, context: bpy.types.Context) -> dict[str, Any]:
        """Return by the names of maps the images to make, the main one first."""
        return {"color": self.active_image(context)}

    def finish(self, context: bpy.types.Context, made: dict[str, Any]) -> None:
        """Use the new images, which have the names of the maps."""
        (image,) = made.values()
        if context.space_data and context.space_data.type == "IMAGE_EDITOR":
            context.space_data.image = image

    def active_image(self, context: bpy.types.Context) -> bpy.types.Image:
        """Return the image of the name that is set, or the one in the editor."""
        if self.image:
            found = bpy.data.images.get(self.image)
            if found is None:
                raise InvalidInputError(f"there is no image '{self.image}'")
            return found
        space = context.space_data
        found = space.image if space and space.type == "IMAGE_EDITOR" else None
        if found is None:
            raise InvalidInputError("open an image in the Image Editor first")
        return found

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Make it and wait, for scripts."""
        if not self._begin(context):
            return {"CANCELLED"}
        self.job.wait()
        return self._end(context)

    def invoke(self, context: bpy.types.Context, event: Any) -> set[str]:
        """Begin with what is set in the sidebar, and return to Blender at once."""
        self._read_sidebar(context)
        return self._run_modal(context)

    def _read_sidebar(self, context: bpy.types.Context) -> None:
        settings = getattr(context.scene, f"weftex_{self.task}")
        for name in PROPERTIES[self.task]:
            if not self.properties.is_property_set(name):
                setattr(self, name, getattr(settings, name))

    def _run_modal(self, context: bpy.types.Context) -> set[str]:
        if not self._begin(context):
            return {"CANCELLED"}
        manager = context.window_manager
        manager.progress_begin(0, 100)
        self.timer = manager.event_timer_add(_TICK, window=context.window)
        manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: Any) -> set[str]:
        """Show how far it is, and cancel it on Esc."""
        if event.type == "ESC":
            self.job.cancel()
        elif event.type != "TIMER":
            return {"PASS_THROUGH"}
        job = self.job
        if job.running:
            share = 100 * job.done // max(job.total, 1)
            context.window_manager.progress_update(share)
            state = "cancelling" if job.cancelled else f"{job.stage}, {share} %; Esc cancels"
            context.workspace.status_text_set(f"weftex: {state}")
            return {"RUNNING_MODAL"}
        context.window_manager.event_timer_remove(self.timer)
        context.window_manager.progress_end()
        context.workspace.status_text_set(None)
        return self._end(context)

    def _begin(self, context: bpy.types.Context) -> bool:
        try:
            self.originals = self.prepare(context)
            pictures = {name: images.picture_of(one) for name, one in self.originals.items()}
            fields = fields_of(self.task, self)
            fields["materials"] = [{"maps": {name: name for name in pictures}}]
            if self.task == "fill" and self.mask:
                mask = bpy.data.images.get(self.mask)
                if mask is None:
                    raise InvalidInputError(f"there is no image '{self.mask}'")
                pictures["the mask"] = images.mask_of(mask)
                fields["mask"] = "the mask"
            self.opened = open_recipe(Recipe.from_json(fields), open_picture=pictures.__getitem__)
        except WeftexError as error:
            self.report({"ERROR"}, str(error))
            return False
        self.job = Job(self._make)
        self.job.start()
        return True

    def _make(self, progress: Any) -> dict[str, Any]:
        """Return the pixels of the result by the names of maps."""
        result = self.opened.make(progress=progress)
        return {next(iter(self.opened.pictures)): result.image, **result.maps}

    def _end(self, context: bpy.types.Context) -> set[str]:
        if self.job.cancelled:
            self.report({"INFO"}, "weftex: cancelled, nothing was changed")
            return {"CANCELLED"}
        if self.job.error:
            self.report({"ERROR"}, self.job.error)
            return {"CANCELLED"}
        made, single = self.job.result, len(self.originals) == 1
        found = {}
        try:
            for name, original in self.originals.items():
                pixels = next(iter(made.values())) if single else made[name]
                found[name] = images.new_image(f"{original.name} {self.suffix}", pixels, original)
            self.finish(context, found)
        except ReferenceError:
            self.report({"ERROR"}, "the image or the material was removed meanwhile")
            return {"CANCELLED"}
        return {"FINISHED"}


_IMAGE = bpy.props.StringProperty(
    name="Image", description="Name of the image; the one in the editor if empty"
)


class WEFTEX_OT_make_more(_Making, bpy.types.Operator):
    """Make a larger texture from this image, as a new image"""

    bl_idname, bl_label, suffix = "weftex.make_more", "Make more", "more"
    __annotations__ = {"image": _IMAGE, **PROPERTIES["synth"]}


class WEFTEX_OT_make_tileable(_Making, bpy.types.Operator):
    """Make this image repeat without a seam, as a new image of the same size"""

    bl_idname, bl_label, suffix = "weftex.make_tileable", "Make tileable", "tileable"
    task = "tile"
    __annotations__ = {"image": _IMAGE, **PROPERTIES["tile"]}


class WEFTEX_OT_fill(_Making, bpy.types.Operator):
    """Fill the transparent pixels, or the white pixels of a mask, as a new image"""

    bl_idname, bl_label, suffix = "weftex.fill", "Fill masked area", "filled"
    task = "fill"
    __annotations__ = {
        "image": _IMAGE,
        "mask": bpy.props.StringProperty(
            name="Mask",
            description="Name of an image that is white where the hole is; "
            "the transparent pixels of the image if empty",
        ),
        **PROPERTIES["fill"],
    }


class WEFTEX_OT_match_maps(_Making, bpy.types.Operator):
    """Make more of all maps of the active material together, in a copy of the material"""

    bl_idname, bl_label, suffix = "weftex.match_maps", "Match maps of this material", "more"
    __annotations__ = {
        "material": bpy.props.StringProperty(
            name="Material", description="Name of the material; the active one if empty"
        ),
        **PROPERTIES["synth"],
    }

    def prepare(self, context: bpy.types.Context) -> dict[str, Any]:
        """Return the images in the nodes of the material."""
        active = context.object.active_material if context.object else None
        self.found = bpy.data.materials.get(self.material) if self.material else active
        if self.found is None:
            raise InvalidInputError("select an object with a material first")
        return materials.images_of(self.found)

    def finish(self, context: bpy.types.Context, made: dict[str, Any]) -> None:
        """Give the active object the copy of the material."""
        replaced = {self.originals[name]: image for name, image in made.items()}
        _assign(context, self.found, materials.with_images(self.found, replaced))


class WEFTEX_OT_new_material(_Making, bpy.types.Operator):
    """Make image files of one material tileable and build a material from them"""

    bl_idname, bl_label, suffix = "weftex.new_material", "New tileable material", "tileable"
    task, asked = "tile", False
    __annotations__ = {
        "directory": bpy.props.StringProperty(subtype="DIR_PATH"),
        "files": bpy.props.CollectionProperty(type=bpy.types.OperatorFileListElement),
        "filter_image": bpy.props.BoolProperty(default=True, options={"HIDDEN"}),
        "filter_folder": bpy.props.BoolProperty(default=True, options={"HIDDEN"}),
        **PROPERTIES["tile"],
    }

    def invoke(self, context: bpy.types.Context, event: Any) -> set[str]:
        """Ask for the files first; then Blender calls `execute`."""
        self.asked = True
        self._read_sidebar(context)
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Begin and return at once if the files were asked for; wait in a script."""
        return self._run_modal(context) if self.asked else super().execute(context)

    def prepare(self, context: bpy.types.Context) -> dict[str, Any]:
        """Load the files; a single one is the color."""
        paths = [os.path.join(self.directory, one.name) for one in self.files if one.name]
        if not paths:
            raise InvalidInputError("choose the image files of one material")
        found: dict[str, Any] = {}
        for path in paths:
            role = role_of(os.path.splitext(os.path.basename(path))[0])
            if role is None and len(paths) > 1:
                raise InvalidInputError(
                    f"cannot tell what {os.path.basename(path)} shows; put the map's role in its "
                    "name, such as wall_roughness.png"
                )
            name = role.name if role else "color"
            if name in found:
                raise InvalidInputError(f"several files are {name}")
            try:
                found[name] = bpy.data.images.load(path, check_existing=True)
            except RuntimeError as error:
                raise InvalidInputError(str(error).strip()) from None
            if role and not role.srgb:
                found[name].colorspace_settings.name = "Non-Color"
        return dict(sorted(found.items(), key=lambda pair: pair[0] != "color"))

    def finish(self, context: bpy.types.Context, made: dict[str, Any]) -> None:
        """Give the active object the new material."""
        stems = [os.path.splitext(one.name)[0] for one in self.files if one.name]
        common = re.match(r"(.+)[-_. ]", os.path.commonprefix(stems))  # noqa: RUF071
        folder = os.path.basename(os.path.normpath(self.directory))
        name = stems[0] if len(stems) == 1 else common[1] if common else folder
        _assign(context, None, materials.new_material(name, made))


def _assign(context: bpy.types.Context, old: Any, new: Any) -> None:
    """Give the active object a material: in the slots of the old one, or in the active slot."""
    target = context.object
    if target is None or not hasattr(target.data, "materials"):
        return
    if old is None:
        target.active_material = new
    for slot in target.material_slots:
        if old is not None and slot.material == old:
            slot.material = new


OPERATORS = (
    WEFTEX_OT_make_more,
    WEFTEX_OT_make_tileable,
    WEFTEX_OT_fill,
    WEFTEX_OT_match_maps,
    WEFTEX_OT_new_material,
)
