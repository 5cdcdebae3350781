#!/usr/bin/env python3
"""weftex in GIMP 3: Filters > weftex.

Each procedure writes pixels to a temporary file, runs the command weftex, and reads the result
back. The image changes only after the run, as one step of undo.
"""

from __future__ import annotations

import os
import re
import sys
from pathlib import Path
from typing import Any

import gi

gi.require_version("Gimp", "3.0")
gi.require_version("Gegl", "0.4")
gi.require_version("Babl", "0.1")
from gi.repository import Babl, Gegl, Gimp, GLib, GObject

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import command
import tiff
from command import Canceled, Problem

_READ_WRITE = GObject.ParamFlags.READWRITE


class Rectangle(tuple):  # type: ignore[type-arg]
    """The x, y, width and height of a part of a drawable."""

    @property
    def gegl(self) -> Any:
        """The rectangle as buffers take it."""
        return Gegl.Rectangle.new(*self)


def format_of(drawable: Any, alpha: bool) -> tuple[str, int]:
    """Return the name and bits of a drawable's format; 32-bit float unless it has 8 or 16 bits."""
    own = drawable.get_format()
    model, kind = Babl.format_get_encoding(own).rsplit(" ", 1)
    kind = kind if kind in ("u8", "u16") else "float"
    encoding = f"{model.rstrip('A')}{'A' * alpha} {kind}"
    name = Babl.get_name(Babl.format_with_space(encoding, own))
    return name, {"u8": 8, "u16": 16, "float": 32}[kind]


def picture_of(drawable: Any, part: Rectangle) -> tiff.Picture:
    """Return pixels of a drawable, without alpha if all are opaque."""
    name, bits = format_of(drawable, drawable.has_alpha())
    channels = (1 if drawable.is_gray() else 3) + drawable.has_alpha()
    data = drawable.get_buffer().get(part.gegl, 1.0, name, Gegl.AbyssPolicy.NONE)
    picture = tiff.Picture(part[2], part[3], channels, bits, data)
    return picture.without_alpha() if picture.opaque else picture


def put(buffer: Any, part: Rectangle, picture: tiff.Picture, like: Any) -> None:
    """Set pixels of a buffer in the format of the drawable `like`."""
    name, _ = format_of(like, picture.channels in (2, 4))
    buffer.set(part.gegl, name, picture.data)
    buffer.flush()


def selected_part(drawable: Any) -> Rectangle:
    """Return the part of a drawable that the selection covers; all of it without a selection."""
    found = drawable.mask_intersect()
    if not found[0]:
        raise Problem("The selection is outside the layer")
    return Rectangle(found[1:])


def selection_of(image: Any, drawable: Any, part: Rectangle) -> tiff.Picture:
    """Return the selection in a part of a drawable, from 0 to 255."""
    _, x, y = drawable.get_offsets()
    on_image = Rectangle((part[0] + x, part[1] + y, part[2], part[3]))
    data = image.get_selection().get_buffer().get(on_image.gegl, 1.0, "Y u8", Gegl.AbyssPolicy.NONE)
    return tiff.Picture(part[2], part[3], 1, 8, data)


def new_layer(image: Any, name: str, picture: tiff.Picture, like: Any) -> Any:
    """Return a new layer with pixels in the format of the drawable `like`; not yet in the image."""
    alpha = like.has_alpha() and picture.channels in (1, 3)
    picture = picture.with_alpha() if alpha else picture
    kind = (Gimp.ImageType.GRAY_IMAGE, Gimp.ImageType.GRAYA_IMAGE, Gimp.ImageType.RGB_IMAGE,
            Gimp.ImageType.RGBA_IMAGE)[picture.channels - 1]  # fmt: skip
    layer = Gimp.Layer.new(
        image, name, picture.width, picture.height, kind, 100, Gimp.LayerMode.NORMAL
    )
    put(layer.get_buffer(), Rectangle((0, 0, picture.width, picture.height)), picture, like)
    return layer


def insert(image: Any, layer: Any, parent: Any, position: int, x: int, y: int) -> None:
    """Insert a layer as one step of undo."""
    image.undo_group_start()
    image.insert_layer(layer, parent, position)
    layer.set_offsets(x, y)
    image.undo_group_end()


def one_drawable(drawables: list[Any]) -> Any:
    """Return the only drawable."""
    if len(drawables) != 1:
        raise Problem("Select one layer")
    drawable = drawables[0]
    if drawable.is_indexed():
        raise Problem("The image has indexed colors; convert it: Image > Mode > RGB")
    return drawable


class Work:
    """Runs the command with files in a temporary folder."""

    def __init__(self, folder: Path, task: str, config: Any) -> None:
        self.folder, self.task, self.values = folder, task, values_of(task, config)
        self.command = command.find_command(_setting())
        command.check_version(self.command)

    def file(self, name: str, picture: tiff.Picture) -> str:
        """Write an input, and return its path."""
        command.check_size(picture.width, picture.height)
        path = self.folder / name
        tiff.write(path, picture)
        return str(path)

    def make(self, *words: str) -> tiff.Picture:
        """Run the command and return its result."""
        output = self.folder / "result.tif"
        given = [self.task, *words, "-o", str(output), *command.words_of(self.task, self.values)]
        Gimp.progress_init("weftex")
        command.run(self.command, given, self._report)
        Gimp.progress_end()
        return tiff.read(output)

    def _report(self, share: float, stage: str) -> bool:
        Gimp.progress_set_text(f"weftex: {stage}")
        Gimp.progress_update(share)
        return True


def make_more(image: Any, drawables: list[Any], work: Work) -> Any:
    """Open a new image, made from the layer or its selected part."""
    drawable = one_drawable(drawables)
    part = selected_part(drawable)
    words = [work.file("sample.tif", picture_of(drawable, part))]
    if not Gimp.Selection.is_empty(image):
        mask = selection_of(image, drawable, part)
        if min(mask.data) < 128:  # not a rectangle
            words += ["--sample-mask", work.file("mask.tif", mask)]
    width, height = work.values.get("size", (0, 0))
    command.check_size(width or height, height or width)
    result = work.make(*words)
    base = Gimp.ImageBaseType.GRAY if result.channels < 3 else Gimp.ImageBaseType.RGB
    made = Gimp.Image.new_with_precision(result.width, result.height, base, image.get_precision())
    made.undo_disable()
    profile = image.get_color_profile()
    if profile is not None and (base == Gimp.ImageBaseType.GRAY) == profile.is_gray():
        made.set_color_profile(profile)
    resolution = image.get_resolution()
    made.set_resolution(*resolution[1:])
    layer = new_layer(made, f"{drawable.get_name()} more", result, drawable)
    made.insert_layer(layer, None, 0)
    made.undo_enable()
    return made


def make_tileable(image: Any, drawables: list[Any], work: Work) -> None:
    """Add a layer that repeats without a seam, above the layer that it is made from."""
    drawable = one_drawable(drawables)
    if not drawable.is_layer():
        raise Problem("Select a layer, not a mask or a channel")
    part = selected_part(drawable)
    result = work.make(work.file("photo.tif", picture_of(drawable, part)))
    layer = new_layer(image, f"{drawable.get_name()} tileable", result, drawable)
    _, x, y = drawable.get_offsets()
    above = image.get_item_position(drawable)
    insert(image, layer, drawable.get_parent(), above, x + part[0], y + part[1])


def heal_selection(image: Any, drawables: list[Any], work: Work) -> None:
    """Replace the selected pixels of the layer by its texture; a feathered edge is mixed."""
    drawable = one_drawable(drawables)
    if Gimp.Selection.is_empty(image):
        raise Problem("Nothing is selected: select what to replace")
    if drawable.is_group():
        raise Problem("A layer group has no pixels of its own: select one of its layers")
    if drawable.get_lock_content():
        raise Problem("The pixels of this layer are locked")
    part = selected_part(drawable)
    whole = Rectangle((0, 0, drawable.get_width(), drawable.get_height()))
    mask = selection_of(image, drawable, whole)
    mask.data = mask.data.translate(bytes([0] + [255] * 255))
    photo = work.file("photo.tif", picture_of(drawable, whole))
    result = work.make(photo, "--mask", work.file("mask.tif", mask))
    put(drawable.get_shadow_buffer(), whole, result, drawable)
    before = own_bytes(drawable, part)
    drawable.merge_shadow(True)
    restore(drawable, part, before, selection_of(image, drawable, part).data)
    drawable.update(*part)


def own_bytes(drawable: Any, part: Rectangle) -> bytes:
    """Return pixels in the drawable's own format."""
    return drawable.get_buffer().get(part.gegl, 1.0, None, Gegl.AbyssPolicy.NONE)  # type: ignore


def restore(drawable: Any, part: Rectangle, before: bytes, mask: bytes) -> None:
    """Set pixels to their former bytes where the mask is 0: GIMP rounds floats there."""
    after = bytearray(own_bytes(drawable, part))
    size = len(after) // len(mask)
    for run in re.finditer(b"\0+", mask):
        start, end = run.start() * size, run.end() * size
        after[start:end] = before[start:end]
    buffer = drawable.get_buffer()
    buffer.set(part.gegl, Babl.get_name(drawable.get_format()), bytes(after))
    buffer.flush()


def fuse_groups(image: Any, drawables: list[Any], work: Work) -> None:
    """Add a layer on top that fuses the samples in layer groups where their masks are painted."""
    groups = [one for one in drawables if one.is_group()]
    groups = groups or [one for one in image.get_layers() if one.is_group() and one.get_visible()]
    groups.sort(key=lambda group: -image.get_item_position(group))
    if len(groups) < 2:
        raise Problem("Two or more layer groups are needed, each with a sample and a mask layer")
    found = Gimp.Selection.bounds(image)
    area = Rectangle((found[2], found[3], found[4] - found[2], found[5] - found[3]))
    labels = bytearray(area[2] * area[3])
    samples = []
    for number, group in enumerate(groups):
        children = group.get_children()
        if not children or len(children) > 2 or (number and len(children) < 2):
            wanted = "one or two layers" if not number else "two layers: a mask above the sample"
            raise Problem(f"The layer group {group.get_name()} needs {wanted}")
        sample = children[-1]
        own = Rectangle((0, 0, sample.get_width(), sample.get_height()))
        samples.append(picture_of(sample, own))
        if number and not paint_label(labels, area, children[0], number):
            raise Problem(f"The mask layer of {group.get_name()} covers nothing")
    missing = [str(k) for k in range(len(groups)) if k not in labels]
    if missing:
        raise Problem(f"Other masks cover {groups[int(missing[0])].get_name()} entirely")
    alpha = any(one.channels in (2, 4) for one in samples)
    samples = [one.with_alpha() if alpha else one for one in samples]
    words = [work.file(f"sample{k}.tif", one) for k, one in enumerate(samples)]
    words += ["--map", work.file("map.tif", tiff.Picture(area[2], area[3], 1, 8, bytes(labels)))]
    words += ["--colors", ",".join(str(k) for k in range(len(groups)))]
    result = work.make(*words)
    layer = new_layer(image, "fused", result, groups[0].get_children()[-1])
    insert(image, layer, None, 0, area[0], area[1])


def paint_label(labels: bytearray, area: Rectangle, mask: Any, label: int) -> bool:
    """Set labels where a mask layer is opaque, or light if it has no alpha; return if any is."""
    _, x, y = mask.get_offsets()
    part = Rectangle((area[0] - x, area[1] - y, area[2], area[3]))
    kind = "A u8" if mask.has_alpha() else "Y' u8"
    cover = mask.get_buffer().get(part.gegl, 1.0, kind, Gegl.AbyssPolicy.NONE)
    labels[:] = bytes(label if a > 127 else b for a, b in zip(cover, labels))  # noqa: B905
    return label in labels


_PROCEDURES = {
    "weftex-make-more": (
        "synth", make_more, "Make _More...",
        ("Open a new image with as much of a texture as you need, made from this layer or its "
         "selected part"),
    ),
    "weftex-make-tileable": (
        "tile", make_tileable, "Make _Tileable...",
        "Add a layer that repeats without a seam, made from this layer or its selected part",
    ),
    "weftex-heal-selection": (
        "fill", heal_selection, "_Heal Selection...",
        "Replace the selected pixels by the texture around them; all others stay unchanged",
    ),
    "weftex-fuse-groups": (
        "fuse", fuse_groups, "_Fuse by Layer Groups...",
        "Add a layer that fuses the samples of layer groups where their mask layers are painted",
    ),
}  # fmt: skip


def values_of(task: str, config: Any) -> dict[str, Any]:
    """Return the values of a procedure's arguments by the names of options."""
    values: dict[str, Any] = {}
    for option in command.options_of(task):
        if option["type"] == "size":
            values["size"] = (config.get_property("width"), config.get_property("height"))
        else:
            values[option["name"]] = config.get_property(option["name"].replace("_", "-"))
    return values


def add_argument(procedure: Any, option: dict[str, Any]) -> None:
    """Add the argument of a procedure for an option."""
    name, title = option["name"].replace("_", "-"), f"_{command.title_of(option)}"
    text = command.about(option)
    if option["type"] == "size":
        for side in ("Width", "Height"):
            text = f"{side} in pixels; 0: {option['default_text']}"
            procedure.add_int_argument(
                side.lower(), f"_{side} (0: default)", text, 0, 262_144, 0, _READ_WRITE
            )
    elif option["type"] == "int":
        seed = name == "seed"
        high, first = (2**31 - 1, 1) if seed else (8192, 0)
        title += "" if seed or option["default"] is not None else " (0: default)"
        procedure.add_int_argument(name, title, text, 0, high, first, _READ_WRITE)
    else:
        pairs, first = command.choices_of(option)
        choice = Gimp.Choice.new()
        for number, (value, label) in enumerate(pairs):
            choice.add(value, number, label, "")
        procedure.add_choice_argument(name, title, text, choice, first, _READ_WRITE)


def _setting() -> str:
    """Return the path of the command that the user wrote in GIMP's own folder."""
    path = Path(Gimp.directory()) / "weftex-command.txt"
    return path.read_text("utf-8").strip() if path.exists() else ""


class WeftexPlugIn(Gimp.PlugIn):
    """The procedures of Filters > weftex."""

    def do_set_i18n(self, name: str) -> bool:
        """Return that there are no translations."""
        return False

    def do_query_procedures(self) -> list[str]:
        """Return the names of the procedures."""
        return list(_PROCEDURES)

    def do_create_procedure(self, name: str) -> Any:
        """Return a procedure with its menu entry and arguments."""
        task, _, label, about = _PROCEDURES[name]
        procedure = Gimp.ImageProcedure.new(self, name, Gimp.PDBProcType.PLUGIN, self._run, None)
        procedure.set_image_types("RGB*, GRAY*")
        procedure.set_menu_label(label)
        procedure.add_menu_path("<Image>/Filters/weftex")
        procedure.set_documentation(about, about, name)
        procedure.set_attribution("The weftex maintainers", "The weftex maintainers", "2026")
        mask = Gimp.ProcedureSensitivityMask.DRAWABLE
        if task == "fuse":
            mask |= Gimp.ProcedureSensitivityMask.DRAWABLES
            mask |= Gimp.ProcedureSensitivityMask.NO_DRAWABLES
        procedure.set_sensitivity_mask(mask)
        for option in command.options_of(task):
            add_argument(procedure, option)
        if task == "synth":
            procedure.add_image_return_value(
                "new-image", "New image", "The result", False, _READ_WRITE
            )
        return procedure

    def _run(
        self, procedure: Any, mode: Any, image: Any, drawables: Any, config: Any, data: Any
    ) -> Any:
        task, make, label, _ = _PROCEDURES[procedure.get_name()]
        if mode == Gimp.RunMode.INTERACTIVE and not _asked(procedure, config, label):
            return procedure.new_return_values(Gimp.PDBStatusType.CANCEL, None)
        try:
            with command.Folder() as folder:
                made = make(image, list(drawables), Work(folder, task, config))
        except Canceled:
            return procedure.new_return_values(Gimp.PDBStatusType.CANCEL, None)
        except command.FAILURES as failure:
            text = command.message_of(failure)
            error = GLib.Error.new_literal(Gimp.PlugIn.error_quark(), text, 0)
            return procedure.new_return_values(Gimp.PDBStatusType.EXECUTION_ERROR, error)
        values = procedure.new_return_values(Gimp.PDBStatusType.SUCCESS, None)
        if made is not None:
            values.remove(1)
            values.insert(1, GObject.Value(Gimp.Image, made))
            if mode != Gimp.RunMode.NONINTERACTIVE:
                Gimp.Display.new(made)
        Gimp.displays_flush()
        return values


def _asked(procedure: Any, config: Any, label: str) -> bool:
    """Show the dialog; return whether the user pressed OK."""
    gi.require_version("GimpUi", "3.0")
    from gi.repository import GimpUi

    GimpUi.init("weftex")
    title = label.replace("_", "").rstrip(".")
    dialog = GimpUi.ProcedureDialog.new(procedure, config, f"weftex: {title}")
    dialog.fill(None)
    done = dialog.run()
    dialog.destroy()
    return bool(done)


Gimp.main(WeftexPlugIn.__gtype__, sys.argv)
