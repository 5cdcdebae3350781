"""Which of the compiled kernels this processor runs.

On x86-64 every kernel is built twice from the same source: for any processor, and for those with
AVX2, which makes patches a fifth faster and long rows twice as fast. Both give the same bytes,
because sums are of integers. Setting WEFTEX_KERNELS=baseline takes the first kind.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from importlib.machinery import ModuleSpec
from types import ModuleType

_ROOT = os.path.dirname(__file__)


class FastKernels:
    """A finder on `sys.meta_path` for the AVX2 build of a kernel, if the processor has AVX2."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Return where the faster build of ``weftex....kernels`` is, or None."""
        if not (fullname.startswith("weftex.") and fullname.endswith("kernels")):
            return None
        if not _processor_is_fast():
            return None
        from importlib.machinery import EXTENSION_SUFFIXES
        from importlib.util import spec_from_file_location

        for suffix in EXTENSION_SUFFIXES:
            file = os.path.join(_ROOT, "_avx2", *fullname.split(".")[1:]) + suffix
            if os.path.exists(file):
                return spec_from_file_location(fullname, file)
        return None


def _processor_is_fast() -> bool:
    if os.environ.get("WEFTEX_KERNELS") == "baseline":
        return False
    try:  # NumPy has asked the processor already
        from numpy._core._multiarray_umath import __cpu_features__ as features
    except ImportError:
        return False
    return bool(features.get("AVX2"))


def prefer_fast_kernels() -> None:
    """Look for faster builds first, whenever a kernel is imported."""
    if not any(isinstance(finder, FastKernels) for finder in sys.meta_path):
        sys.meta_path.insert(0, FastKernels())
