"""Minimum cuts of grids by max-flow, and least paths.

Each cut along a path is a dynamic program, and each has its own costs and steps:

| function | path | used by |
|---|---|---|
| `methods.patches.patch_kernels.cut_bands` | over pixels, 8 neighbors, free ends | quilting |
| `methods.ashikhmin.choice.least_path` | over pixels, open or closed | ashikhmin, wrapped output |

Cuts of any shape are by `maxflow`: graphcut, `boundary` (fuse and fill), `merge` (fuse).
"""
