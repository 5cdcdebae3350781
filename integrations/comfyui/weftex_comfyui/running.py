"""Progress, previews and interruption, as ComfyUI shows and asks for them."""

from __future__ import annotations

from collections.abc import Callable
from time import perf_counter
from typing import Any

import comfy.model_management
import comfy.utils
from comfy.cli_args import LatentPreviewMethod, args
from PIL import Image

_PAUSE = 0.1  # seconds between two updates of the bar
_PREVIEW_PAUSE = 1.0
_PREVIEW_SIDE = 512  # pixels


def progress_of(number: int, count: int) -> Callable[..., bool]:
    """Return a callback for image `number` of a batch; it raises if the user interrupts."""
    bar = comfy.utils.ProgressBar(1)
    shows = args.preview_method != LatentPreviewMethod.NoPreviews
    next_bar = next_preview = perf_counter()

    def callback(done: int, total: int, stage: str, preview: Callable[[], Any]) -> bool:
        nonlocal next_bar, next_preview
        comfy.model_management.throw_exception_if_processing_interrupted()
        now = perf_counter()
        if now >= next_bar or done >= total:
            picture = None
            due = shows and done and now >= next_preview
            if due and (pixels := preview()) is not None:  # which it is during an analysis
                pixels = pixels[..., 0] if pixels.shape[2:] == (1,) else pixels
                picture = ("JPEG", Image.fromarray(pixels).convert("RGB"), _PREVIEW_SIDE)
                next_preview = perf_counter() + _PREVIEW_PAUSE
            bar.update_absolute(number * total + done, count * total, picture)
            next_bar = perf_counter() + _PAUSE
        return True

    return callback
