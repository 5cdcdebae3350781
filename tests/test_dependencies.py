"""Imports point one way, and importing weftex costs next to nothing."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent / "src" / "weftex"

#: From the top down; a module may import from its own level and from those below.
LEVELS = [
    ["__main__", "cli"],
    ["commands"],
    ["options", "terminal", "pictures"],
    ["tasks"],
    ["quality"],
    ["methods"],
    ["method"],
    ["search", "seams", "analysis"],
    ["synthesis", "patch_synthesis", "pixel_synthesis", "warped_synthesis"] + ["saved", "drawing"],
    ["exemplar", "canvas", "_compositing", "_warp_kernels"],
    ["io"],
    ["formats"],
    ["progress", "random"],
    ["errors", "_cpu"],
]
LEVEL = {name: n for n, names in enumerate(reversed(LEVELS)) for name in names}
# Parts of one level that have nothing to do with each other.
APART = [{"search", "seams"}, {"search", "analysis"}, {"seams", "analysis"}]
KERNELS = sorted(p.relative_to(ROOT) for p in ROOT.rglob("*kernels.py"))
FILES = sorted(p.relative_to(ROOT) for p in ROOT.rglob("*.py"))


def dotted(path):
    parts = path.with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


MODULES = {dotted(path) for path in FILES}


def imports(path):
    """(module of weftex, when) of every import: "start", "later" in a function, "types" only."""
    tree = ast.parse((ROOT / path).read_text())
    found = []

    def visit(node, when):
        if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
            when = "types"
        elif isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)) and when == "start":
            when = "later"
        if isinstance(node, ast.Import):
            found.extend((name.name, when) for name in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: imports are absolute"
            for name in node.names:
                found.append((f"{node.module}.{name.name}", when))
        for child in ast.iter_child_nodes(node):
            visit(child, when)

    visit(tree, "start")
    result = set()
    for name, when in found:
        name = name.removeprefix("cython.cimports.")
        if name == "weftex" or name.startswith("weftex."):
            name = name.removeprefix("weftex").removeprefix(".")
            while name and name not in MODULES:
                name = name.rpartition(".")[0]
            if name:
                result.add((name, when))
    return result


def part(module):
    return module.split(".")[0]


def test_every_part_has_a_level():
    unknown = {part(dotted(path)) for path in FILES} - set(LEVEL) - {""}
    assert not unknown, f"add {sorted(unknown)} to the list in this test and to the design"


@pytest.mark.parametrize("path", FILES, ids=str)
def test_imports_point_down(path):
    module = dotted(path)
    if not module:
        return  # weftex/__init__.py names everything, lazily
    for other, _ in imports(path):
        if part(other) == part(module):
            continue
        assert LEVEL[part(other)] <= LEVEL[part(module)], f"{module} imports {other}"
        assert {part(other), part(module)} not in APART, f"{module} imports {other}"


def test_no_circles():
    graph = {dotted(p): {m for m, when in imports(p) if when == "start"} for p in FILES}

    def reaches(start):
        seen, stack = set(), list(graph[start])
        while stack:
            module = stack.pop()
            if module not in seen:
                seen.add(module)
                stack.extend(graph.get(module, ()))
        return seen

    assert [m for m in graph if m in reaches(m)] == []


@pytest.mark.parametrize("path", KERNELS, ids=str)
def test_kernels_depend_on_kernels_only(path):
    """A kernel fills arrays: no files, no randomness, no NumPy, no errors to raise."""
    for other, _ in imports(path):
        assert Path(*other.split(".")).with_suffix(".py") in KERNELS
    tree = ast.parse((ROOT / path).read_text())
    for node in ast.walk(tree):
        assert not isinstance(node, ast.Raise)
        names = [n.name for n in node.names] if isinstance(node, ast.Import) else []
        if isinstance(node, ast.ImportFrom):
            names = [node.module]
        assert all(n == "cython" or n.startswith("cython.cimports.") for n in names)


def test_kernels_are_found():
    assert len(KERNELS) >= 3


def test_only_io_and_results_touch_files():
    """`open`, OpenImageIO and os.replace elsewhere would be a second place for files."""
    for path in FILES:
        if part(dotted(path)) in ("io", "formats", "saved"):
            continue
        for node in ast.walk(ast.parse((ROOT / path).read_text())):
            if isinstance(node, ast.Call):
                name = ast.unparse(node.func)
                assert name not in ("open", "os.replace", "os.rename", "np.load", "np.save"), path
            if isinstance(node, ast.Import):
                assert all(n.name.split(".")[0] != "OpenImageIO" for n in node.names), path


def modules_after(code):
    done = subprocess.run(
        [sys.executable, "-c", f"{code}\nimport sys; print(' '.join(sys.modules))"],
        capture_output=True,
        text=True,
        check=True,
    )
    return set(done.stdout.split())


HEAVY = {
    "OpenImageIO", "scipy", "PIL", "tqdm", "concurrent.futures", "multiprocessing", "argparse",
    "json", "inspect", "difflib", "unittest", "Cython", "numpy.random", "numpy.fft",
}  # fmt: skip


def test_importing_weft_is_light():
    before, after = modules_after("import numpy"), modules_after("import numpy, weftex")
    added = {m for m in after - before if not m.startswith("weftex")}
    assert not added & HEAVY
    assert len(added) <= 5, sorted(added)
    assert {m for m in after if m.startswith("weftex")} <= {"weftex", "weftex.errors"}


def test_a_run_on_arrays_loads_no_more_than_it_needs():
    code = (
        "import numpy as np, weftex\n"
        "sample = (np.arange(60 * 60) % 251).astype(np.uint8).reshape(60, 60)\n"
        "weftex.synthesize(sample, 100, method='patch-sampling', seed=1).image"
    )
    needless = {"OpenImageIO", "scipy", "PIL", "tqdm", "multiprocessing", "concurrent.futures"}
    needless |= {"numpy.random", "difflib", "weftex.io.pictures"}
    # A method that was named pays nothing for choosing one, or for measures.
    needless |= {"weftex.tasks.auto", "weftex.analysis.lattice", "weftex.quality"}
    assert not modules_after(code) & needless


def test_a_command_with_a_method_neither_chooses_nor_measures(tmp_path):
    words = ["synth", "sample:grass", "-o", f"{tmp_path}/o.png", "--size", "64", "--quiet"]
    code = f"from weftex.cli import main\nassert main({[*words, '--method', 'quilting']}) == 0"
    needless = (
        "weftex.quality",
        "weftex.tasks.auto",
        "weftex.analysis.lattice",
        "weftex.tasks.report",
    )
    assert [m for m in modules_after(code) if m.startswith(needless)] == []


def test_public_names_are_all_there():
    import weftex

    assert set(weftex.__all__) == set(weftex._HOME)
    for name in weftex.__all__:
        assert getattr(weftex, name) is not None
        assert name in dir(weftex)
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        weftex.nothing  # noqa: B018
