"""weftex samples: list the samples that ship with weftex."""

from __future__ import annotations

from weftex.cli.parser import Parser


def run(argv: list[str]) -> None:
    """Run the command; `argv` is what follows its name."""
    Parser("samples", "List the samples that ship with weftex.", "").parse(argv)
    from weftex.io.pictures import is_folder, sample_names

    for name in sample_names():
        folder = "  (a folder of aligned maps)" if is_folder(f"sample:{name}") else ""
        print(f"sample:{name}{folder}")
