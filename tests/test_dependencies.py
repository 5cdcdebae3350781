"""Imports point one way, and importing weftex costs next to nothing.

The graph has an arrow for every import statement of every module, wherever it stands (in functions
and under TYPE_CHECKING too), for every cimport, also of declarations (`.pxd`), and for every string
that names a module of weftex. The lazy tables of `weftex/__init__.py` and `registry` are left out.
"""

import ast
import re
from functools import cache
from pathlib import Path

import pytest

import weftex
from processes import run

ROOT = Path(__file__).parent.parent / "src" / "weftex"

#: Rooms from the top down; a module imports from its own room and from those below.
LEVELS = [
    ["__main__"],
    ["cli"],
    ["studio"],
    ["planes", "pages"],
    ["recipe", "atlas"],
    ["tasks"],
    ["methods"],
    ["naming"],
    ["method"],
    ["endless"],
    ["quality", "prepare"],
    ["guides"],
    ["analysis"],
    ["repeats"],
    ["search", "seams"],
    ["results"],
    ["canvas", "label_maps"],
    ["exemplar"],
    ["io"],
    ["raster", "reference"],
    ["registry", "threads", "processes", "progress", "random", "roles"],
    ["parameters"],
    ["errors"],
    ["dispatch"],
]
LEVEL = {room: level for level, rooms in enumerate(reversed(LEVELS)) for room in rooms}
#: Rooms that use the library by its public names.
GUESTS = ("studio", "planes", "pages")
MOST_METHOD_ROOMS = 14
#: Strings that read like modules: the group of entry points by which packages add methods, and
#: the folder of the page's files.
NO_MODULES = {("registry", "weftex.methods"), ("studio.app", "weftex.studio")}


def dotted(path):
    parts = path.with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


FILES = {
    dotted(path): path
    for path in sorted(p.relative_to(ROOT) for p in ROOT.rglob("*.py"))
    if path.parts[0] != "_avx2"
}


def room(module):
    return module.split(".")[0]


def is_kernel(module):
    return module.endswith("kernels")


def module_of(name):
    """The module of weftex that a dotted name is or lies in, or None; "" is weftex itself."""
    name = name.removeprefix("cython.cimports.")
    if name != "weftex" and not name.startswith("weftex."):
        return None
    name = name.removeprefix("weftex").removeprefix(".")
    while name not in FILES:
        name = name.rpartition(".")[0]
    return name


def imported(tree):
    """Dotted names of all import statements."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (name.name for name in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, "imports are absolute"
            yield from (f"{node.module}.{name.name}" for name in node.names)


def declared(text):
    """Dotted names that declarations of a kernel cimport."""
    for module, names in re.findall(r"^from (\S+) cimport (.*)", text, re.M):
        yield from (f"{module}.{name}" for name in re.findall(r"\w+", names))
    yield from re.findall(r"^cimport (\S+)", text, re.M)


def named(tree):
    """Strings that begin as modules do, but docstrings; "weftex.cli.commands." of an f-string."""
    docstrings = {
        node.body[0].value
        for node in ast.walk(tree)
        if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef))
        and node.body
        and isinstance(node.body[0], ast.Expr)
    }
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            found = re.match(r"weftex\.[\w.]+", node.value)
            if found and node not in docstrings:
                yield found.group()


@cache
def graph():
    """{module: modules that it has an arrow to}."""
    arrows = {}
    for module, path in FILES.items():
        tree = ast.parse((ROOT / path).read_text("utf-8"))
        pxd = (ROOT / path).with_suffix(".pxd")
        text = pxd.read_text("utf-8") if pxd.exists() else ""
        found = {module_of(name) for name in (*imported(tree), *declared(text))}
        for name in named(tree):
            if (module, name) in NO_MODULES:
                continue
            start = name.removeprefix("weftex.")
            if name.endswith("."):  # whichever lies below
                found |= {other for other in FILES if other.startswith(start)}
            else:
                found.add(module_of(name))
        if module:
            arrows[module] = sorted(found - {None, module})
    return arrows


def circles():
    """Sets of modules that all lead to each other (strongly connected components)."""

    @cache
    def reached(start):
        seen, waiting = set(), list(graph()[start])
        while waiting:
            module = waiting.pop()
            if module and module not in seen:
                seen.add(module)
                waiting.extend(graph()[module])
        return seen

    found = {
        tuple(sorted(other for other in reached(m) if m in reached(other)))
        for m in graph()
        if m in reached(m)
    }
    return sorted(found)


def arrows():
    return ((module, other) for module, others in graph().items() for other in others)


def none_of(offences):
    if offences := list(offences):
        pytest.fail("\n".join(offences), pytrace=False)


def test_every_room_has_a_level():
    none_of(sorted({room(module) for module in graph()} - set(LEVEL)))


def test_no_circles():
    none_of(" <-> ".join(circle) for circle in circles())


def test_arrows_point_down():
    """Rooms of one level have nothing to do with each other; only guests import weftex itself."""
    none_of(
        f"{module} -> {other or 'weftex'}"
        for module, other in arrows()
        if room(module) != room(other)
        and not (other == "" and room(module) in GUESTS)
        and LEVEL.get(room(other), len(LEVELS)) >= LEVEL.get(room(module), 0)
    )


def faces():
    """{module: its public names}, of each module that states them in a list."""
    found = {"": {*weftex.__all__, "__version__"}}
    for module, path in FILES.items():
        stated = re.search(r"^__all__ = (\[.*?\])$", (ROOT / path).read_text("utf-8"), re.M | re.S)
        if stated:
            found[module] = set(ast.literal_eval(stated[1]))
    return found


def test_guests_use_public_names_only():
    """What a user could write: they import only names that a module states as public."""
    public, offences = faces(), []
    for module, path in FILES.items():
        for node in ast.walk(ast.parse((ROOT / path).read_text("utf-8"))):
            if room(module) in GUESTS and isinstance(node, ast.ImportFrom):
                other = module_of(node.module)
                if other is not None and room(other) != room(module):
                    names = {name.name for name in node.names} - public.get(other, set())
                    offences += [f"{module} -> {node.module}.{name}" for name in sorted(names)]
    none_of(offences)


def test_references_stand_alone():
    """They are read without the package: arrays, errors and random numbers."""
    none_of(
        f"{module} -> {other}"
        for module, other in arrows()
        if room(module) == "reference" and room(other) not in ("reference", "errors", "random")
    )


def test_parts_of_a_method_do_not_import_the_method():
    """`__init__` -> model -> parts -> settings; and a method finds others by `registry.METHODS`."""
    none_of(
        f"{module} -> {other}"
        for module, other in arrows()
        if module.startswith("methods.") and (other == "methods" or module.startswith(f"{other}."))
    )


def test_kernels_depend_on_kernels_only():
    """A kernel fills arrays: no files, no randomness, no NumPy, no errors to raise."""
    kernels = [module for module in graph() if is_kernel(module)]
    assert len(kernels) >= 3
    offences = [f"{m} -> {o}" for m, o in arrows() if is_kernel(m) and not is_kernel(o)]
    for module in kernels:
        tree = ast.parse((ROOT / FILES[module]).read_text("utf-8"))
        offences += [
            f"{module} imports {name}"
            for name in imported(tree)
            if not name.startswith(("cython", "__future__"))
        ]
        if any(isinstance(node, ast.Raise) for node in ast.walk(tree)):
            offences.append(f"{module} raises")
    none_of(offences)


def test_methods_have_few_rooms():
    rooms = {module.split(".")[1] for module in graph() if module.startswith("methods.")}
    assert len(rooms) <= MOST_METHOD_ROOMS, sorted(rooms)


def test_the_graph_sees_every_kind_of_arrow():
    """One of each kind, so that none is lost unseen."""
    assert "errors" in graph()["io.pictures"]  # a plain import
    assert "analysis.overlay" in graph()["studio.app"]  # a string
    assert "cli.commands.batch" in graph()["cli"]  # the beginning of one
    assert any(is_kernel(a) and is_kernel(b) for a, b in arrows())  # a cimport
    text = "cimport cython\nfrom weftex.search.window_kernels cimport Windows, settle\n"
    assert [module_of(name) for name in declared(text)] == ["search.window_kernels"] * 2 + [None]


#: Where files are opened, and where OpenImageIO is.
FILE_MODULES = ("io.", "results.saved", "planes.")
FILE_MODULES += ("studio.sessions", "studio.uploads", "studio.exports")


def test_only_io_results_and_planes_touch_files():
    """`open`, OpenImageIO and os.replace elsewhere would be a second place for files."""
    offences = []
    for module, path in FILES.items():
        if module.startswith(FILE_MODULES):
            continue
        tree = ast.parse((ROOT / path).read_text("utf-8"))
        calls = {ast.unparse(node.func) for node in ast.walk(tree) if isinstance(node, ast.Call)}
        calls &= {"open", "os.replace", "os.rename", "np.load", "np.save", "np.savez"}
        offences += [f"{module} calls {name}" for name in sorted(calls)]
        offences += [f"{module} imports {n}" for n in imported(tree) if n.startswith("OpenImageIO")]
    none_of(offences)


def modules_after(code):
    return set(run(f"{code}\nimport sys; print(' '.join(sys.modules))").stdout.split())


HEAVY = {
    "OpenImageIO", "scipy", "PIL", "tqdm", "concurrent.futures", "multiprocessing", "argparse",
    "json", "inspect", "difflib", "unittest", "Cython", "numpy.random", "numpy.fft",
}  # fmt: skip


def test_importing_weft_is_light():
    before, after = modules_after("import numpy"), modules_after("import numpy, weftex")
    added = {m for m in after - before if not m.startswith("weftex")}
    assert not added & HEAVY
    assert len(added) <= 5, sorted(added)
    own = {m for m in after if m.startswith("weftex")}
    assert own <= {"weftex", "weftex.errors", "weftex.dispatch"}


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


def test_every_task_on_arrays_works_without_openimageio():
    code = (
        "import sys, numpy as np, weftex\nfrom weftex.prepare import even_light\n"
        "sys.modules['OpenImageIO'] = None\n"
        "sample = np.random.default_rng(1).integers(0, 255, (60, 60, 3), np.uint8)\n"
        "made = weftex.synthesize(even_light(sample), 80, seed=1)\n"
        "print(made.render(sample[..., 0]).shape, weftex.assess(sample, made).score)\n"
        "weftex.tile(sample, seed=1), weftex.fill(sample, np.eye(60) > 0, seed=1)\n"
        "weftex.fuse([sample, 255 - sample], 'gradient', 60, seed=1), weftex.analyze(sample)"
    )
    assert "weftex.tasks.fuse" in modules_after(code)


@pytest.mark.parametrize("sample", ["bricks", "pebbles", "weave", "leaves"])
def test_a_choice_loads_nothing_that_only_costs_time(sample):
    code = f"import weftex\nweftex.synthesize('sample:{sample}', 100, seed=1).image"
    assert not modules_after(code) & {"numpy.ma", "numpy.random", "fractions", "decimal", "scipy"}


def test_a_command_with_a_method_neither_chooses_nor_measures(tmp_path):
    words = ["synth", "sample:grass", "-o", f"{tmp_path}/o.png", "--size", "64", "--quiet"]
    code = f"from weftex.cli import main\nassert main({[*words, '--method', 'quilting']}) == 0"
    needless = ("weftex.quality", "weftex.analysis.lattice")
    needless += ("weftex.tasks.auto", "weftex.pages.reports")
    assert [m for m in modules_after(code) if m.startswith(needless)] == []


#: Public modules; the pages of Python list their names, and test_readme.py compares.
MODULES = ("atlas", "label_maps", "pages", "planes", "prepare", "reference")


def test_public_names_are_few_and_there():
    assert len(weftex.__all__) <= 32 and weftex.__all__ == sorted(weftex.__all__)
    assert {*weftex.__all__, *MODULES} <= {*dir(weftex)}
    for module in (weftex, *(getattr(weftex, name) for name in MODULES)):
        assert module.__doc__ and all(getattr(module, name) is not None for name in module.__all__)
        assert module is weftex or not {*module.__all__} & {*weftex.__all__}
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        weftex.nothing  # noqa: B018
