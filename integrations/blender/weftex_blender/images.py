"""Images of Blender as pictures of weftex, and results as new images."""

from __future__ import annotations

import bpy
import numpy as np

from weftex.errors import InvalidInputError
from weftex.io.pictures import Picture


def picture_of(image: bpy.types.Image) -> Picture:
    """Return the pixels of an image, first row on top: uint8, or float32 of float images."""
    width, height = image.size
    if image.source == "TILED":
        raise InvalidInputError(f"{image.name} is a UDIM of several tiles; use one image")
    if not width or not height:
        raise InvalidInputError(f"{image.name} has no pixels; is its file missing?")
    flat = np.empty(width * height * image.channels, np.float32)
    image.pixels.foreach_get(flat)
    pixels = flat.reshape(height, width, image.channels)[::-1]
    if pixels.shape[2] == 4 and (pixels[..., 3] == 1).all():
        pixels = pixels[..., :3]
    alpha = pixels.shape[2] == 4
    if alpha and image.alpha_mode == "PREMUL":
        share = pixels[..., 3:]
        pixels = np.concatenate([pixels[..., :3] / np.where(share > 0, share, 1), share], axis=2)
    if pixels.shape[2] == 3 and (pixels == pixels[..., :1]).all():
        pixels = pixels[..., 0]
    if not image.is_float:
        pixels = np.rint(pixels * 255).astype(np.uint8)
    return Picture(np.ascontiguousarray(pixels), alpha, None, image.name)


def mask_of(image: bpy.types.Image) -> Picture:
    """Return an image as a mask, which is white where the hole is."""
    picture = picture_of(image)
    if picture.pixels.ndim == 3 and not picture.alpha:
        return Picture(picture.pixels.mean(axis=2).astype(picture.pixels.dtype), False, None, "")
    return picture


def new_image(name: str, pixels: np.ndarray, like: bpy.types.Image) -> bpy.types.Image:
    """Return a new, packed image with the color space of another one."""
    height, width = pixels.shape[:2]
    values = pixels / 255 if pixels.dtype == np.uint8 else pixels
    rgba = np.ones((height, width, 4), np.float32)
    if values.ndim == 2:
        values = values[..., None]
    if values.shape[2] == 2:  # gray with alpha
        values = values[..., [0, 0, 0, 1]]
    rgba[..., : max(3, values.shape[2])] = values
    image = bpy.data.images.new(name, width, height, alpha=values.shape[2] == 4,
                                float_buffer=pixels.dtype != np.uint8)  # fmt: skip
    image.colorspace_settings.name = like.colorspace_settings.name
    image.pixels.foreach_set(rgba[::-1].ravel())
    image.update()
    image.pack()
    return image
