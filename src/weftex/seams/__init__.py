"""Joining patches."""
