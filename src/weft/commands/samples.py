"""weft samples: list the samples that ship with weft."""

from __future__ import annotations

from weft.options import Parser


def run(argv: list[str]) -> None:
    """Run the command; `argv` is what follows its name."""
    Parser("samples", "List the samples that ship with weft.", "").parse(argv)
    from weft import io

    for name in io.sample_names():
        folder = "  (a folder of aligned maps)" if io.is_folder(f"sample:{name}") else ""
        print(f"sample:{name}{folder}")
