"""Slow, obvious twins of weftex's kernels and orderings, written from the definitions.

One module for a method whose reference lacks much, and one for each thing that methods share.
Nothing here is clever, and nothing is shared with the package but the bytes that matching looks at
(`Exemplar.matching`, which has tests of its own) and the nouns.
"""
