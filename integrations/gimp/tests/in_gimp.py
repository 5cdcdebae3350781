"""Runs inside GIMP: does the jobs in jobs.json, and writes the images afterwards to done.json."""

import json
import os
import traceback
from pathlib import Path

import gi

gi.require_version("Gimp", "3.0")
gi.require_version("Gegl", "0.4")
gi.require_version("Babl", "0.1")
from gi.repository import Babl, Gegl, Gimp

FOLDER = Path(os.environ["WEFTEX_TEST_FOLDER"])
TYPES = {
    1: Gimp.ImageType.GRAY_IMAGE,
    2: Gimp.ImageType.GRAYA_IMAGE,
    3: Gimp.ImageType.RGB_IMAGE,
    4: Gimp.ImageType.RGBA_IMAGE,
}


def whole(drawable):
    return Gegl.Rectangle.new(0, 0, drawable.get_width(), drawable.get_height())


def add(image, spec, parent=None):
    """Add a layer from a file with its pixels, or a group with its layers, at the bottom."""
    position = len(parent.get_children() if parent else image.get_layers())
    if "layers" in spec:
        group = Gimp.GroupLayer.new(image, spec["name"])
        image.insert_layer(group, parent, position)
        for one in spec["layers"]:
            add(image, one, group)
        return
    width, height = spec["size"]
    layer = Gimp.Layer.new(
        image, spec["name"], width, height, TYPES[spec["channels"]], 100, Gimp.LayerMode.NORMAL
    )
    image.insert_layer(layer, parent, position)
    layer.set_offsets(*spec.get("offset", (0, 0)))
    name = Babl.get_name(layer.get_format())
    layer.get_buffer().set(whole(layer), name, (FOLDER / spec["file"]).read_bytes())
    if spec.get("mask"):
        layer.add_mask(layer.create_mask(Gimp.AddMaskType.BLACK))
        layer.set_edit_mask(False)
    if spec.get("locked"):
        layer.set_lock_content(True)


def select(image, spec):
    kind, *numbers = spec
    if kind == "rectangle":
        image.select_rectangle(Gimp.ChannelOps.REPLACE, *numbers)
    elif kind == "add":
        image.select_rectangle(Gimp.ChannelOps.ADD, *numbers)
    elif kind == "ellipse":
        image.select_ellipse(Gimp.ChannelOps.REPLACE, *numbers)
    elif kind == "feather":
        Gimp.Selection.feather(image, *numbers)


def described(image, name):
    """Write the pixels of all layers to files, and return what else there is to know."""
    found, waiting = [], [(one, 0) for one in image.get_layers()]
    while waiting:
        layer, depth = waiting.pop(0)
        if layer.is_group():
            children = [(one, depth + 1) for one in layer.get_children()]
            waiting = children + waiting
        file = f"{name}-{len(found)}.raw"
        data = layer.get_buffer().get(whole(layer), 1.0, None, Gegl.AbyssPolicy.NONE)
        (FOLDER / file).write_bytes(data)
        found.append({
            "name": layer.get_name(),
            "size": [layer.get_width(), layer.get_height()],
            "offset": list(layer.get_offsets()[1:]),
            "format": Babl.get_name(layer.get_format()),
            "depth": depth,
            "file": file,
        })  # fmt: skip
    return {"size": [image.get_width(), image.get_height()], "layers": found}


def do(number, job):
    base = Gimp.ImageBaseType.GRAY if job["base"] == "GRAY" else Gimp.ImageBaseType.RGB
    image = Gimp.Image.new_with_precision(
        *job["size"], base, getattr(Gimp.Precision, job["precision"])
    )
    if job.get("profile") == "adobe":
        image.set_color_profile(Gimp.ColorProfile.new_rgb_adobe())
    for spec in job["layers"]:
        add(image, spec)
    if job.get("indexed"):
        image.convert_indexed(
            Gimp.ConvertDitherType.NONE, Gimp.ConvertPaletteType.GENERATE, 16, False, False, ""
        )
    for spec in job.get("select", []):
        select(image, spec)
    before = described(image, f"{number}-before")
    procedure = Gimp.get_pdb().lookup_procedure(job["procedure"])
    config = procedure.create_config()
    config.set_property("run-mode", Gimp.RunMode.NONINTERACTIVE)
    config.set_property("image", image)
    named = {one.get_name(): one for one in image.get_layers()}
    chosen = [named[name] for name in job.get("drawables", list(named)[:1])]
    if job.get("edit") == "mask":
        chosen = [one.get_mask() for one in chosen]
    config.set_core_object_array("drawables", chosen)
    for name, value in job.get("values", {}).items():
        config.set_property(name, value)
    result = procedure.run(config)
    status = result.index(0)
    done = {"status": status.value_nick, "error": Gimp.get_pdb().get_last_error()}
    done |= {"before": before, "after": described(image, f"{number}-after")}
    if status == Gimp.PDBStatusType.SUCCESS and job["procedure"] == "weftex-make-more":
        made = result.index(1)
        done["made"] = described(made, f"{number}-made")
        profile = made.get_color_profile()
        done["made"]["profile"] = profile.get_description() if profile else ""
        made.delete()
    image.delete()
    return done


JOBS = json.loads((FOLDER / "jobs.json").read_text("utf-8"))
try:
    DONE = [do(number, job) for number, job in enumerate(JOBS)]
except Exception:
    (FOLDER / "failed.txt").write_text(traceback.format_exc(), "utf-8")
    raise
(FOLDER / "done.json").write_text(json.dumps(DONE), "utf-8")
