"""What each command of `weft` takes and does: its `run`, which cli.py calls."""
