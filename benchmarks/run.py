"""Speed, memory, start-up, growth: run by hand or by CI, never a test.

    python benchmarks/run.py [all | TABLE ...] [--json FILE] [--update docs/benchmarks.md]

The tables of the patch methods are in patch.py, those of the pixel methods in pixel.py, those of
near-regular textures in near_regular.py, those of whole processes in process.py, those of measures
and of quality against time in judging.py; --help names them. Prints Markdown. Every time is a
median of several runs, and what is compared is run in turn, so that a busy machine disturbs all
alike; look at the ratios first. --update puts the tables into a page between its <!-- NAME --> and
<!-- end NAME --> lines and charts beside it, and names the machine. Pictures and scores of all
methods are gallery.py's. Needs weftex[test].
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import judging
import near_regular
import patch
import pixel
import process
from shared import Table, in_child, machine, papers, put

TABLES: dict[str, Callable[[], Table]] = {
    table.__name__: table
    for module in (patch, process, pixel, near_regular, judging)
    for table in module.TABLES
}


def main() -> None:
    if len(sys.argv) == 3 and sys.argv[1] == "--child":
        print(json.dumps(in_child(**json.loads(sys.argv[2]))))
        return
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "tables", nargs="*", default=["all"], metavar="TABLE", help=f"all, {', '.join(TABLES)}"
    )
    parser.add_argument("--json", type=Path, metavar="FILE")
    parser.add_argument("--update", type=Path, metavar="PAGE")
    args = parser.parse_args()
    everything = "all" in args.tables
    names = list(TABLES) if everything else args.tables
    if unknown := [name for name in names if name not in TABLES]:
        parser.error(f"unknown table '{unknown[0]}'; known: {', '.join(TABLES)}, all")
    about = machine()
    measured = f"Measured on: {about}.\n"
    print(f"{about}\n")
    found: dict[str, Any] = {"machine": about}
    for name in names:
        table = TABLES[name]()
        text = papers.as_markdown(table)
        print(f"## {name}\n\n{text}", flush=True)
        found[name] = {"notes": table[0].strip(), "head": table[1], "rows": table[2]}
        if args.update:
            put(args.update, name, text if everything else f"{text}\n{measured}")
            if name in judging.CHARTS:
                chart = args.update.parent / "img" / f"{name}.svg"
                chart.write_text(judging.CHARTS[name](table[2]), encoding="utf-8")
    if args.update and everything:
        put(args.update, "machine", measured)
    if args.json:
        args.json.write_text(json.dumps(found, indent=1), encoding="utf-8")


if __name__ == "__main__":
    main()
