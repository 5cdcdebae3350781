"""Speed, memory, start-up, growth: docs/lab/measured/benchmarks.md; run by hand, never a test.

    python benchmarks/speed/run.py [all | TABLE ...] [--json FILE] [--update [PAGE]] [--small]

The tables of the patch methods are in patch.py, those of the pixel methods in pixel.py, those of
near-regular textures in near_regular.py, those of whole processes in process.py and everyday.py,
those of measures and of quality against time in judging.py; --help names them. Prints Markdown.
Every time is a median of several runs, in seconds of processor time (by the clock only where
threads are counted), and what is compared is run in turn, so that other work on the machine
disturbs all alike; look at the ratios first. --update writes the tables into the page, each with
the machine it was measured on, and charts beside it; tables that were not made stay. --small shows
that all of it runs, and measures nothing. Pictures and scores of all methods are gallery.py's.
Needs weftex[test].
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import everyday
import judging
import near_regular
import patch
import pixel
import process
from shared import ROOT, Table, in_child, machine, papers

PAGE = ROOT / "docs" / "lab" / "measured" / "benchmarks.md"
_HEAD = """\
# Benchmarks: tables

`python benchmarks/speed/run.py all --update` writes this page, and
`python benchmarks/speed/run.py TABLE --update` one table of it; edits are lost.
[How to read them](../../background/benchmarks.md).
"""

TABLES: dict[str, Callable[[], Table]] = {
    table.__name__: table
    for module in (patch, process, pixel, near_regular, judging, everyday)
    for table in module.TABLES
}


def update(page: Path, name: str, text: str) -> None:
    """Write the section of one table; the others stay."""
    old = page.read_text(encoding="utf-8") if page.exists() else ""
    sections = dict(part.split("\n\n", 1) for part in old.split("\n## ")[1:])
    sections[name] = f"{TABLES[name].__doc__}\n\n{text}"
    whole = [f"## {one}\n\n{sections[one].rstrip()}\n" for one in TABLES if one in sections]
    page.write_text("\n".join([_HEAD, *whole]), encoding="utf-8")


def main(words: Sequence[str] | None = None) -> None:
    words = sys.argv[1:] if words is None else words
    if len(words) == 2 and words[0] == "--child":
        print(json.dumps(in_child(**json.loads(words[1]))))
        return
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "tables", nargs="*", default=["all"], metavar="TABLE", help=f"all, {', '.join(TABLES)}"
    )
    parser.add_argument("--json", type=Path, metavar="FILE")
    parser.add_argument("--update", type=Path, nargs="?", const=PAGE, metavar="PAGE")
    parser.add_argument("--small", action="store_true", help="of 64 pixels, once; not for the page")
    args = parser.parse_args(words)
    if args.small and args.update == PAGE:
        parser.error("--small measures nothing; name another page to update")
    papers.make_small(args.small)
    everything = "all" in args.tables
    names = list(TABLES) if everything else args.tables
    if unknown := [name for name in names if name not in TABLES]:
        parser.error(f"unknown table '{unknown[0]}'; known: {', '.join(TABLES)}, all")
    about = machine()
    print(f"{about}\n")
    found: dict[str, Any] = {"machine": about}
    for name in names:
        table = TABLES[name]()
        text = papers.as_markdown(table)
        print(f"## {name}\n\n{text}", flush=True)
        found[name] = {"notes": table[0].strip(), "head": table[1], "rows": table[2]}
        if args.update:
            text += f"\nMeasured on: {about}.\n"
            if name in judging.CHARTS:
                chart = args.update.with_name(f"{name}.svg")
                chart.write_text(judging.CHARTS[name](table[2]), encoding="utf-8")
                text += f"\n![{TABLES[name].__doc__}]({chart.name})\n"
            update(args.update, name, text)
    if args.json:
        args.json.write_text(json.dumps(found, indent=1), encoding="utf-8")


if __name__ == "__main__":
    main()
