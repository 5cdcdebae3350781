"""Cuts of any shape: max-flow, least paths, belts.

Quilting cuts with `weftex.methods.patches.patch_kernels.cut_bands`; patches are feathered by
`weftex.results.paste_kernels.blend`.
"""
