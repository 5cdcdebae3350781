"""Ceilings for the size of the code base; `benchmarks/guards/size.py` prints them."""

import ast
import sys
from functools import cache
from pathlib import Path

import pytest

import weftex
from test_dependencies import FILES, ROOT, graph, is_kernel, room

TESTS = Path(__file__).parent
#: Rooms of which a reader of a method reads what it imports.
READ = ("methods", "repeats", "search", "seams")
#: Lower a ceiling when the code has become smaller; a feature that needs room removes something.
CEILINGS = {
    "lines of Python in src": 43_093,
    "of these code": 29_487,
    "modules": 258,
    "kernel classes": 22,
    "names that several kernel classes have": 0,
    "lines of tests": 23_864,
    "quilting: files to read": 11,
    "quilting: lines to read": 2_458,
    "graphcut: files to read": 18,
    "graphcut: lines to read": 3_530,
    "efros-leung: files to read": 8,
    "efros-leung: lines to read": 1_164,
    "near-regular: files to read": 9,
    "near-regular: lines to read": 1_578,
}


def modules_of(slug):
    """The module of a method, and all that it imports, directly or not."""
    found, waiting = set(), [f"methods.{slug.replace('-', '_')}"]
    while waiting:
        name = waiting.pop()
        if name and name not in found:
            found.add(name)
            waiting += graph()[name]
    return found


def to_read(slug):
    return {module for module in modules_of(slug) if room(module) in READ}


def lines_of(modules):
    """Lines of modules, with the declarations of kernels."""
    files = [ROOT / FILES[module] for module in modules]
    files += [f.with_suffix(".pxd") for f in files if f.with_suffix(".pxd").exists()]
    return sum(len(file.read_text("utf-8").splitlines()) for file in files)


def code_in(text):
    """Lines that are neither blank, comment nor docstring."""
    lines = text.splitlines()
    total = sum(line.strip() != "" and not line.strip().startswith("#") for line in lines)
    for node in ast.walk(ast.parse(text)):
        alone = isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
        if alone and isinstance(node.value.value, str):
            said = lines[node.lineno - 1 : node.end_lineno]
            total -= sum(line.strip() != "" for line in said)
    return total


def kernel_classes():
    """Names of all extension classes of kernels."""
    for module, path in FILES.items():
        if is_kernel(module):
            tree = ast.parse((ROOT / path).read_text("utf-8"))
            yield from (node.name for node in ast.walk(tree) if isinstance(node, ast.ClassDef))


@cache
def measured():
    """{measure: today's figure} for every ceiling."""
    texts = [(ROOT / path).read_text("utf-8") for path in FILES.values()]
    classes = list(kernel_classes())
    tests = sorted(TESTS.rglob("*.py"))
    found = {
        "lines of Python in src": sum(len(text.splitlines()) for text in texts),
        "of these code": sum(map(code_in, texts)),
        "modules": len(FILES),
        "kernel classes": len(classes),
        "names that several kernel classes have": len(
            {name for name in classes if classes.count(name) > 1}
        ),
        "lines of tests": sum(len(f.read_text("utf-8").splitlines()) for f in tests),
    }
    for slug in ("quilting", "graphcut", "efros-leung", "near-regular"):
        found[f"{slug}: files to read"] = len(to_read(slug))
        found[f"{slug}: lines to read"] = lines_of(to_read(slug))
    return found


@pytest.mark.parametrize("name", CEILINGS)
def test_nothing_grows(name):
    assert measured()[name] <= CEILINGS[name]


def test_the_script_prints_every_measure(capsys):
    sys.path.insert(0, str(TESTS.parent / "benchmarks" / "guards"))
    import size

    size.main()
    printed = capsys.readouterr().out
    assert all(f"| {name} | " in printed for name in [*CEILINGS, *weftex.METHODS])
