"""Shared by the methods over a lattice: near-regular synthesis and the best tile.

`weftex.analysis.lattice` finds the lattice.
"""
