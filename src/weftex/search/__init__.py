"""Nearest neighborhoods: each structure once."""
