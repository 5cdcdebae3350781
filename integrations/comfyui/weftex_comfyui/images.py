"""Tensors of ComfyUI as materials of weftex, and results as tensors.

Images of ComfyUI are floats, encoded as sRGB. Images whose values are all those of 8 bits are
uint8 in weftex, so that they give the pixels that the command line makes of the file. All others
keep their floats. Maps of a set are as weftex stores them, where colors in floats are linear light.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import torch

from weftex.exemplar.material import Material
from weftex.io.pictures import Picture
from weftex.raster.levels import to_light, to_stored
from weftex.roles import COLOR, Role

_CLOSE = 1e-6  # to a level of 8 bits


def has_8_bits(image: torch.Tensor) -> bool:
    """Whether all values of an image are levels of 8 bits."""
    values = _array(image)
    return bool((np.abs(np.rint(np.clip(values, 0, 1) * 255) / 255 - values) < _CLOSE).all())


def materials_of(
    image: torch.Tensor, role: Role = COLOR, *, eight: bool | None = None
) -> list[Material]:
    """Return a material for each image of a batch (B, H, W, C) with values 0 to 1.

    Pixels are uint8 if `eight`, else float32; by default as the image `has_8_bits`.
    """
    values = _array(image)
    if has_8_bits(image) if eight is None else eight:
        values = np.rint(values * 255).astype(np.uint8)
    return [_material(one, role) for one in values]


def _array(image: torch.Tensor) -> Any:
    return image.detach().cpu().to(torch.float32).numpy()


def _material(pixels: Any, role: Role) -> Material:
    # ComfyUI loads gray files as RGB; alpha is no color.
    if pixels.shape[2] != 4 and (pixels == pixels[..., :1]).all():
        pixels = pixels[..., 0]
    alpha = pixels.ndim == 3 and pixels.shape[2] in (2, 4)
    picture = Picture(np.ascontiguousarray(pixels), alpha, None, role.name)
    return Material("image", {role.name: picture}, {role.name: role})


def masks_of(mask: torch.Tensor) -> list[Picture]:
    """Return a picture for each mask of a batch (B, H, W) or of one (H, W)."""
    values = _array(mask)
    levels = np.rint(np.clip(values, 0, 1) * 255).astype(np.uint8)
    return [Picture(one, False, None, "mask") for one in levels.reshape(-1, *levels.shape[-2:])]


def batch_of(pictures: list[Any]) -> torch.Tensor:
    """Return pixels of one shape as a batch; gray becomes RGB, gray with alpha RGBA."""
    return torch.from_numpy(np.stack([_values(pixels) for pixels in pictures]))


def _values(pixels: Any) -> Any:
    top = np.iinfo(pixels.dtype).max if pixels.dtype.kind == "u" else 1
    values = np.atleast_3d(pixels).astype(np.float32) / np.float32(top)
    if values.shape[2] < 3:
        values = values[..., [0, 0, 0, *range(1, values.shape[2])]]
    return values


def lit(material: Material) -> Material:
    """Return a material of an image as one of a set: encoded floats become linear light."""
    return _converted(material, to_light)


def encoded(material: Material) -> Material:
    """Return a material of a set as one of an image: linear floats become encoded."""
    return _converted(material, to_stored)


def _converted(material: Material, convert: Callable[[Any], Any]) -> Material:
    pictures = dict(material.pictures)
    for name, picture in pictures.items():
        if material.roles[name].srgb and picture.pixels.dtype.kind == "f":
            pixels = picture.pixels.copy()
            colors = pixels[..., :-1] if picture.alpha else pixels
            colors[...] = np.copysign(convert(np.abs(colors.astype(np.float64))), colors)
            pictures[name] = replace(picture, pixels=pixels)
    return replace(material, pictures=pictures)
