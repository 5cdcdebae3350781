"""How to choose the pixels: one file a method, named after its slug."""

from weft._cpu import prefer_fast_kernels

prefer_fast_kernels(__name__, __path__)
