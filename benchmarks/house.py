"""The house in figures: arrows between modules, and how much there is to read for each method.

    python benchmarks/house.py

For each method: the files and lines that its package and its family hold, of these code (neither
blank, comment nor docstring), and of these kernels and declarations; and the same for everything
that it imports, the common spine of the house included.
"""

from __future__ import annotations

import ast
import sys
from functools import cache
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parent.parent / "tests"))
import weftex
from test_dependencies import FILES, LEVEL, ROOT, arrows, circles, graph, is_kernel, room


def closure(module: str) -> set[str]:
    """A module and all that it leads to."""
    found: set[str] = set()
    waiting = [module]
    while waiting:
        name = waiting.pop()
        if name and name not in found:
            found.add(name)
            waiting += graph()[name]
    return found


def files_of(modules: set[str]) -> list[Path]:
    """Modules and their declarations."""
    files = [ROOT / FILES[module] for module in modules]
    return files + [f.with_suffix(".pxd") for f in files if f.with_suffix(".pxd").exists()]


def lines_of(modules: set[str]) -> int:
    return sum(len(file.read_text("utf-8").splitlines()) for file in files_of(modules))


def code_of(modules: set[str]) -> int:
    return sum(map(code_in, files_of(modules)))


@cache
def code_in(file: Path) -> int:
    """Lines that are neither blank, comment nor docstring."""
    text = file.read_text("utf-8")
    lines = text.splitlines()
    total = sum(line.strip() != "" and not line.strip().startswith("#") for line in lines)
    for node in ast.walk(ast.parse(text)) if file.suffix == ".py" else ():
        alone = isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
        if alone and isinstance(node.value.value, str):
            said = lines[node.lineno - 1 : node.end_lineno]
            total -= sum(line.strip() != "" for line in said)
    return total


def main() -> None:
    upward = [pair for pair in arrows() if LEVEL[room(pair[0])] < LEVEL.get(room(pair[1]), 99)]
    rooms = {module.split(".")[1] for module in graph() if module.startswith("methods.")}
    print(
        f"{len(graph())} modules, {len(list(arrows()))} arrows, {len(circles())} circles, "
        f"{len(upward)} upward arrows, {len(rooms)} rooms in methods/\n"
    )
    print(
        "| method | files | lines | of these code | of these kernels "
        "| all files | all lines | of these code | of these kernels |"
    )
    print("|---|---|---|---|---|---|---|---|---|")
    for slug in weftex.METHODS:
        everything = closure(f"methods.{slug.replace('-', '_')}")
        cells: list[int] = []
        for part in ({m for m in everything if room(m) == "methods"}, everything):
            kernels = set(filter(is_kernel, part))
            cells += [len(part), lines_of(part), code_of(part), lines_of(kernels)]
        print(f"| {slug} | " + " | ".join(map(str, cells)) + " |")


if __name__ == "__main__":
    main()
