"""What the menu does: a task writes its inputs first, and adds a layer or a document at the end."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from krita import Krita
from PyQt5.QtCore import QRect

from . import command, layers, pixels, tiff
from .command import Problem


class Task:
    """One run; `words` are those of its command line, with the inputs in a folder."""

    title, task, about = "", "", ""

    def __init__(self, document: Any, node: Any, values: dict[str, Any], folder: Path) -> None:
        if document is None or node is None:
            raise Problem("Open an image and select a layer")
        document.waitForDone()
        self.document, self.node, self.folder = document, node, folder
        self.selection = document.selection()
        self.output = folder / "result.tif"
        inputs = self.inputs(values)
        own = command.words_of(self.task, values)
        self.words = [self.task, *inputs, "-o", str(self.output), *own]

    def file(self, name: str, picture: tiff.Picture) -> str:
        """Write an input, and return its path."""
        command.check_size(picture.width, picture.height)
        path = self.folder / name
        tiff.write(path, picture)
        return str(path)

    def inputs(self, values: dict[str, Any]) -> list[str]:
        """Write the inputs, and return the words that name them."""
        raise NotImplementedError

    def finish(self) -> Any:
        """Use the result; return the new layer or document."""
        raise NotImplementedError

    def add_layer(self, name: str, picture: tiff.Picture, x: int, y: int) -> Any:
        """Add a layer above the one that it is made from, and return it."""
        layer = layers.new_layer(self.document, name, picture, self.node, x, y)
        self.node.parentNode().addChildNode(layer, self.node)
        self.document.refreshProjection()
        self.document.setModified(True)
        return layer


class MakeMore(Task):
    """Opens a new image."""

    title, task = "Make More", "synth"
    about = "Open a new image, made from this layer or its selected part."

    def inputs(self, values: dict[str, Any]) -> list[str]:
        """Write the sample, and a mask unless the selection is a rectangle."""
        width, height = values.get("size", (0, 0))
        command.check_size(width or height, height or width)
        area = layers.area_of(self.document, self.node)
        words = [self.file("sample.tif", layers.picture_of(self.node, area))]
        if self.selection is not None:
            mask = layers.mask_of(self.selection, area)
            if min(mask) < 128:
                picture = tiff.Picture(area.width(), area.height(), 1, 8, mask)
                words += ["--sample-mask", self.file("mask.tif", picture)]
        return words

    def finish(self) -> Any:
        """Open the result."""
        name = f"{self.node.name()} more"
        made = layers.new_document(name, tiff.read(self.output), self.document, self.node)
        window = Krita.instance().activeWindow()
        if window is not None:
            window.addView(made)
        return made


class MakeTileable(Task):
    """Adds a layer that repeats without a seam."""

    title, task = "Make Tileable", "tile"
    about = "Add a layer that repeats without a seam, made from this layer or its selected part."

    def inputs(self, values: dict[str, Any]) -> list[str]:
        """Write the photo."""
        self.area = layers.area_of(self.document, self.node)
        return [self.file("photo.tif", layers.picture_of(self.node, self.area))]

    def finish(self) -> Any:
        """Add the result above."""
        name = f"{self.node.name()} tileable"
        return self.add_layer(name, tiff.read(self.output), self.area.x(), self.area.y())


class HealSelection(Task):
    """Adds a layer that covers the selection with the texture around it."""

    title, task = "Heal Selection", "fill"
    about = "Add a layer that covers the selection with the texture around it."

    def inputs(self, values: dict[str, Any]) -> list[str]:
        """Write the photo and the selection."""
        if self.selection is None or rectangle_empty(self.selection):
            raise Problem("Nothing is selected: select what to replace")
        self.part = layers.area_of(self.document, self.node)
        canvas = QRect(0, 0, self.document.width(), self.document.height())
        self.area = self.node.bounds().intersected(canvas)
        mask = layers.mask_of(self.selection, self.area).translate(bytes([0] + [255] * 255))
        hole = tiff.Picture(self.area.width(), self.area.height(), 1, 8, mask)
        photo = self.file("photo.tif", layers.picture_of(self.node, self.area))
        return [photo, "--mask", self.file("mask.tif", hole)]

    def finish(self) -> Any:
        """Add the selected part of the result above; feathered edges are its alpha."""
        x, y = self.part.x() - self.area.x(), self.part.y() - self.area.y()
        picture = tiff.read(self.output).cropped(x, y, self.part.width(), self.part.height())
        picture = pixels.covered(picture, layers.mask_of(self.selection, self.part))
        return self.add_layer(f"{self.node.name()} healed", picture, self.part.x(), self.part.y())


def rectangle_empty(selection: Any) -> bool:
    """Return whether nothing is selected."""
    return bool(layers.rectangle_of(selection).isEmpty())


TASKS = (MakeMore, MakeTileable, HealSelection)
