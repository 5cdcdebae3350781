"""Joining patches."""

from weft._cpu import prefer_fast_kernels

prefer_fast_kernels(__name__, __path__)
