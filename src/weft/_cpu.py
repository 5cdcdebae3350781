"""Which of the compiled kernels this processor should run.

On x86-64 every kernel is built twice from the same source: for any processor, and for those with
AVX2, which makes patches a fifth faster and long rows twice as fast. Both give the same bytes,
because sums are of integers. Setting WEFT_KERNELS=baseline takes the first kind.
"""

from __future__ import annotations

import os

import weft


def prefer_fast_kernels(package: str, path: list[str]) -> None:
    """Put the AVX2 folder of a package before its own, if it exists and the processor has AVX2."""
    inner = package.split(".")[1:]
    root = os.path.dirname(__file__)
    folder = os.path.join(root, "_avx2", *inner)
    if not os.path.isdir(folder) or os.environ.get("WEFT_KERNELS") == "baseline":
        return
    try:  # NumPy has asked the processor already
        from numpy._core._multiarray_umath import __cpu_features__ as features
    except ImportError:
        return
    if features.get("AVX2"):
        path.insert(0, folder)


prefer_fast_kernels("weft", weft.__path__)
