"""Layers, selections and documents of Krita as pictures, and results as new layers."""

from __future__ import annotations

from typing import Any

from krita import Krita
from PyQt5.QtCore import QRect

from . import pixels, tiff
from .command import Problem

_AT_ONCE = 2**26  # bytes; Krita's byte arrays hold 2 GiB


def picture_of(node: Any, area: QRect) -> tiff.Picture:
    """Return the pixels of a layer, or what is visible of a layer that has none of its own."""
    model, depth = node.colorModel(), node.colorDepth()
    row = area.width() * pixels.pixel_size(model, depth)
    read = node.pixelData if node.type() == "paintlayer" else node.projectionPixelData
    parts = []
    for top, rows in _strips(area.height(), row):
        parts.append(bytes(read(area.x(), area.y() + top, area.width(), rows)))
    data = b"".join(parts)
    if len(data) != row * area.height():
        raise Problem(f"{node.name()} has no pixels")
    return pixels.to_picture(data, area.width(), area.height(), model, depth)


def put(node: Any, picture: tiff.Picture, x: int, y: int) -> None:
    """Set pixels of a layer."""
    data = pixels.from_picture(picture, node.colorDepth())
    row = len(data) // picture.height
    for top, rows in _strips(picture.height, row):
        part = data[top * row : (top + rows) * row]
        node.setPixelData(part, x, y + top, picture.width, rows)


def _strips(height: int, row: int) -> list[tuple[int, int]]:
    """Return the first row and the number of rows of parts that Krita can pass on."""
    rows = max(1, _AT_ONCE // row)
    return [(top, min(rows, height - top)) for top in range(0, height, rows)]


def area_of(document: Any, node: Any) -> QRect:
    """Return the part of a layer that has pixels, within the canvas and around the selection."""
    area = node.bounds().intersected(QRect(0, 0, document.width(), document.height()))
    if area.isEmpty():
        raise Problem(f"{node.name()} has no pixels on the canvas")
    chosen = document.selection()
    if chosen is not None:
        area = area.intersected(rectangle_of(chosen))
        if area.isEmpty():
            raise Problem("The selection is outside the layer")
    return area


def rectangle_of(selection: Any) -> QRect:
    """Return the rectangle around a selection."""
    return QRect(selection.x(), selection.y(), selection.width(), selection.height())


def mask_of(selection: Any, area: QRect) -> bytes:
    """Return a selection in an area, from 0 to 255."""
    return bytes(selection.pixelData(area.x(), area.y(), area.width(), area.height()))


def new_layer(document: Any, name: str, picture: tiff.Picture, like: Any, x: int, y: int) -> Any:
    """Return a new layer in the color space of a layer; it is not in the document yet."""
    node = document.createNode(name, "paintlayer")
    node.setColorSpace(like.colorModel(), like.colorDepth(), like.colorProfile())
    put(node, picture, x, y)
    return node


def new_document(name: str, picture: tiff.Picture, document: Any, node: Any) -> Any:
    """Return a new document with one layer, in the color space of a layer."""
    made = Krita.instance().createDocument(
        picture.width, picture.height, name, node.colorModel(), node.colorDepth(),
        node.colorProfile(), document.resolution(),
    )  # fmt: skip
    layer = made.rootNode().childNodes()[0]  # a new document has one, which undo cannot remove
    layer.setName(name)
    put(layer, picture, 0, 0)
    made.refreshProjection()
    made.setModified(True)
    return made
