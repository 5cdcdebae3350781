"""What each command of `weftex` takes and does: its `run`, which cli.py calls."""
