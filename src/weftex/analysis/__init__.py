"""Analyze a sample: its lattice, its scale, and other properties.

The lattice by chapter 3 of the thesis on near-regular textures, in its order; `weftex.reference`
has it as one function: `correlation` (3.1 and 3.2), `autocorrelations` and their peaks (3.3, step
1), `pairs` and their goodness (steps 2 to 6), `lattice`.

What the thesis lacks, and photos need, can be skipped: `evidence` weighs what speaks for a lattice
or for rows, from `tile_multiples` (smaller, larger), `lines` (ridges, joints) and `bonds`.
`rows` finds boards, for near-regular synthesis and graph cut.
"""
