"""``python -m weftex``: the command line."""

from weftex.cli import entry

if __name__ == "__main__":
    entry()
