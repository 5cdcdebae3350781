"""Shared by the methods that paste patches: patch-based sampling and image quilting."""
