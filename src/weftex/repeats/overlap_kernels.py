# mypy: ignore-errors
"""What two boxes of an output repeat of the sample; compiled by Cython, see setup.py and the .pxd."""

import cython  # noqa: F401
