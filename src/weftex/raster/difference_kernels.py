# mypy: ignore-errors
"""Squared differences of bytes; compiled by Cython, see setup.py and the .pxd."""

import cython  # noqa: F401
