"""How to choose the pixels: one package a method, named after its slug.

Patch-based sampling and quilting are a module each, over the shared package `patches`.
`weftex.registry` finds a method by its slug.
"""
