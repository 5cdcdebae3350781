"""The nodes beside a few functions that stand in for ComfyUI's; torch is the real one."""

from __future__ import annotations

import os
import sys
import types
from pathlib import Path

import pytest

pytest.importorskip("torch", reason="the nodes need PyTorch")
sys.path.insert(0, os.environ.get("WEFTEX_NODES", str(Path(__file__).resolve().parents[1])))


class Interrupted(Exception):
    """Raised as ComfyUI's own, which is no error of weftex."""


class Host:
    """What the nodes told ComfyUI, and what they were given."""

    def __init__(self) -> None:
        self.input = self.output = ""
        self.updates: list[tuple[int, int, object]] = []
        self.interrupt_after = 10**9


HOST = Host()


def _module(name: str, **members: object) -> None:
    sys.modules[name] = types.ModuleType(name)
    vars(sys.modules[name]).update(members)


class _Bar:
    def __init__(self, total: int) -> None:
        self.total = total

    def update_absolute(self, value: int, total: int, preview: object) -> None:
        HOST.updates.append((value, total, preview))


def _interrupt() -> None:
    HOST.interrupt_after -= 1
    if HOST.interrupt_after < 0:
        raise Interrupted


def _save_path(prefix: str, root: str, width: int, height: int) -> tuple[str, str, int, str, str]:
    below, stem = os.path.split(prefix)
    folder = os.path.join(root, below)
    os.makedirs(folder, exist_ok=True)
    there = [name for name in os.listdir(folder) if name.startswith(f"{stem}_")]
    return folder, stem, len(there) + 1, below, prefix


_module("comfy")
_module("comfy.utils", ProgressBar=_Bar)
_module("comfy.model_management", throw_exception_if_processing_interrupted=_interrupt)
_methods = types.SimpleNamespace(NoPreviews="none", Auto="auto")
_args = types.SimpleNamespace(preview_method="auto")
_module("comfy.cli_args", LatentPreviewMethod=_methods, args=_args)
sys.modules["comfy"].utils = sys.modules["comfy.utils"]
sys.modules["comfy"].model_management = sys.modules["comfy.model_management"]
_module(
    "folder_paths",
    get_input_directory=lambda: HOST.input,
    get_output_directory=lambda: HOST.output,
    get_save_image_path=_save_path,
)


@pytest.fixture
def host(tmp_path):
    """A ComfyUI with empty folders."""
    HOST.__init__()
    HOST.input, HOST.output = str(tmp_path / "input"), str(tmp_path / "output")
    os.mkdir(HOST.input)
    os.mkdir(HOST.output)
    return HOST
