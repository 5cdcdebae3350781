"""What a reader of the README, of a page or of an example would paste does run."""

import ast
import dataclasses
import functools
import importlib
import itertools
import os
import re
import runpy
import shlex
import sys
import sysconfig
import tomllib
from pathlib import Path

import pytest

import weftex
from commands import weft_run
from test_dependencies import MODULES
from weftex.quality.figures import FIGURES
from weftex.registry import METHODS

ROOT = Path(__file__).parent.parent
PAGES = sorted(p for p in [ROOT / "README.md", *ROOT.glob("docs/**/*.md")] if p.exists())
EXAMPLES = sorted(ROOT.glob("examples/*.py"))
PAPERS = sorted(p for p in ROOT.glob("examples/papers/*.py") if p.name[0] != "_")
#: A line that a page says a command prints: of weftex synth, or of weftex analyze.
SAID = r"^    (weftex: .+|map: .+|(?:scale|lattice|auto|runner-up 1|tileable) {3}.+| {14}\S.+)$"
#: Parameters of all methods, as options.
PARAMETERS = " ".join(
    f"--{field.name.replace('_', '-')}" for m in METHODS.values() for field in dataclasses.fields(m)
)


def blocks(page, language):
    """The fenced code of one language."""
    return re.findall(rf"^```{language}\n(.*?)^```$", page.read_text("utf-8"), re.M | re.S)


def run_script(script, words, monkeypatch):
    """What `python script words` does, in this process."""
    monkeypatch.syspath_prepend(script.parent)
    monkeypatch.setattr(sys, "argv", [str(script), *map(str, words)])
    runpy.run_path(str(script), run_name="__main__")


def smaller(size):
    """Half of a size, and half of that while a side has over 300 pixels; none below 128."""
    if size.endswith("m"):  # meters, which depend on the sample
        return size
    sides = [int(side.replace("k", "")) * 1024 ** side.count("k") for side in size.split("x")]
    while True:
        sides = [max(side // 2, min(side, 128)) for side in sides]
        if max(sides) <= 300:
            return "x".join(map(str, sides))


@pytest.mark.pages
@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_commands_of_pages(page, tmp_path, monkeypatch, capsys):
    """In the order of the page, in one folder: a command may use what an earlier one made."""
    monkeypatch.chdir(tmp_path)
    for line in (line for block in blocks(page, "sh") for line in block.splitlines()):
        words = shlex.split(line, comments=True)
        if words[:1] == ["mkdir"]:
            Path(words[1]).mkdir()
        if words[:1] == ["weftex"]:
            kept = ("benchmarks/", "examples/")  # samples of the repository
            words = [str(ROOT / w) if w.startswith(kept) else w for w in words]
            options = itertools.pairwise(words)
            words[2:] = [smaller(b) if a == "--size" else b for a, b in options][1:]
            assert weft_run(*words[1:]) == 0, line
            assert "-o" not in words or Path(words[words.index("-o") + 1]).exists(), line
    said = "".join(capsys.readouterr())
    for line in re.findall(SAID, page.read_text("utf-8"), re.M):
        assert line in said


@pytest.mark.pages
@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_python_of_pages(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PATH", sysconfig.get_path("scripts"), prepend=os.pathsep)  # activated
    for block in blocks(page, "python"):
        exec(compile(block, str(page), "exec"), {})


@pytest.mark.pages
@pytest.mark.parametrize("example", EXAMPLES, ids=lambda example: example.name)
def test_examples(example, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    small = ["--size", 96] if "--size" in example.read_text("utf-8") else []
    run_script(example, ["-o", tmp_path, *small], monkeypatch)
    assert list(tmp_path.iterdir())


@functools.cache
def experiments(script):
    """Names of what a script's tables FIGURES and TABLES list."""
    lists = [
        node.value.elts
        for node in ast.parse(script.read_text("utf-8")).body
        if isinstance(node, ast.Assign) and node.targets[0].id in ("FIGURES", "TABLES")
    ]
    return [name.id for names in lists for name in names]


@pytest.mark.pages
@pytest.mark.parametrize(
    "script, experiment",
    [
        pytest.param(script, name, id=f"{script.stem}-{name}")
        for script in PAPERS
        for name in experiments(script)
    ],
)
def test_experiments_of_papers(script, experiment, tmp_path, monkeypatch, capsys):
    """Small ones, in this process: none is left out of what its script runs for `all`."""
    run_script(script, [experiment, "--small", "-o", tmp_path], monkeypatch)
    assert [path.suffix for path in tmp_path.iterdir()] in ([".png"], [".md"])
    assert capsys.readouterr().out.splitlines()[-1].startswith(f"{experiment}: ")


def code_of(page):
    """All that a page shows as code: lines of fenced blocks, and spans."""
    text = page.read_text("utf-8")
    fenced = r"^```\w*\n(.*?)^```$"
    lines = [line for block in re.findall(fenced, text, re.M | re.S) for line in block.splitlines()]
    return lines + re.findall(r"`([^`\n]+)`", re.sub(fenced, "", text, flags=re.M | re.S))


@pytest.mark.parametrize("page", [*PAGES, ROOT / "CONTRIBUTING.md"], ids=lambda page: page.name)
def test_named_scripts_are_run_by_a_test(page):
    """Examples and experiments by those above; what is left by test_gallery and test_benchmarks."""
    others = {
        f"benchmarks/{folder}/{name}.py"
        for folder, names in {
            "guards": ("digests", "many_threads", "size", "soak"),
            "pages": ("notebooks", "pictures", "references"),
            "quality": ("fusion", "gallery", "lattices", "planes", "repeats"),
            "speed": ("commits", "everyday", "planes_on_disk", "run", "studio", "studio_page"),
        }.items()
        for name in names
    }
    for code in code_of(page):
        named = re.match(
            r"(?:python )?((?:examples(?:/papers)?|benchmarks/\w+)/\w+\.py)\b(.*)", code.strip()
        )
        if not named:
            assert not re.search(r"\b(examples|benchmarks)/[\w/]+\.py", code), code
            continue
        script, words = ROOT / named[1], shlex.split(named[2], comments=True)
        if script in PAPERS:
            given = {word for word in words if word.islower() and word[0] != "-"}
            assert given <= {*experiments(script), "all"}
        else:
            assert script in EXAMPLES or named[1] in others, code


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_named_commands_are_there(page, capsys):
    """In running text too: the command and its options are there; methods list parameters."""
    spans = [span.split("#")[0].split() for span in code_of(page)]
    for words in (words[1:] for words in spans if words[:1] == ["weftex"] and len(words) > 1):
        if words[0] == "methods" and words[1:] and words[1].islower():
            assert weft_run(*words[:2]) == 0
        assert weft_run(words[0], "--help") == 0
        allowed = capsys.readouterr().out
        if words[0] in ("synth", "fill", "fuse"):
            allowed += PARAMETERS
        options = [word for word in words if re.fullmatch("--[a-z-]+", word)]
        assert [option for option in options if option not in allowed] == []


def test_papers_have_experiments():
    assert len(PAPERS) >= 6 and all(len(experiments(script)) >= 4 for script in PAPERS)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_of_pages(page):
    """Every file that a page names is there."""
    text = re.sub(r"^```.*?^```$", "", page.read_text("utf-8"), flags=re.M | re.S)
    targets = re.findall(r"\]\(([^)#\s]+)[^)]*\)", text)
    files = [page.parent / target for target in targets if "://" not in target]
    assert [str(file) for file in files if not file.exists()] == []


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_to_headings(page):
    """The part of a link after # is a heading of the page it leads to."""
    for target, part in re.findall(r"\]\(([^)#\s]*)#([^)\s]+)\)", page.read_text("utf-8")):
        if "://" not in target:
            text = (page.parent / target if target else page).read_text("utf-8")
            heads = re.findall(
                r"^#+ (.*)", re.sub(r"^```.*?^```$", "", text, flags=re.M | re.S), re.M
            )
            names = [re.sub(r"[^\w\- ]", "", head.lower()).replace(" ", "-") for head in heads]
            assert part in names, f"{target}#{part}"


def test_the_page_of_measures_lists_every_figure_as_it_is():
    page = ROOT.joinpath("docs", "reference", "measures.md").read_text("utf-8")
    for figure in FIGURES.values():
        limit = figure.within() or "describes only"
        row = f"| {figure.title} | {figure.unit} | {limit} | {figure.meaning} | {figure.blind} |"
        assert row in page


def test_the_pages_of_python_list_every_public_name():
    pages = (page.read_text("utf-8") for page in ROOT.glob("docs/reference/python/*.md"))
    listed = re.findall(r"^::: (\S+)\.(\w+)$", "\n".join(pages), re.M)
    modules = {module: importlib.import_module(f"weftex.{module}") for module in MODULES}
    wanted = {name for module in (weftex, *modules.values()) for name in module.__all__}
    beside = {"Model", "Analysis", "Lattice", "Choice", "Entry", "Picture"}
    beside |= {"ProgressCallback", "listening", "parameter", "Ratings"}
    beside |= {"Rated", "Evenness", "MapReport", "Definition", "Progress"}
    assert {name for _, name in listed} == wanted - {"METHODS"} | beside
    assert all(hasattr(importlib.import_module(module), name) for module, name in listed)


def test_the_readme_has_the_two_commands():
    first, second = (line for b in blocks(ROOT / "README.md", "sh") for line in b.splitlines()
                     if line.startswith("python3 -m venv"))  # fmt: skip
    assert " weftex synth sample:" in first.replace(".venv/bin/weftex", "weftex")
    assert second.endswith("-m pytest -n auto")


def test_no_other_package_is_told_to_be_installed():
    """Another one has nearly our name: a text that named it would fetch a stranger's code."""
    folders = (ROOT / "src" / "weftex", ROOT / "examples", ROOT / "benchmarks")
    files = [*PAGES, ROOT / "CONTRIBUTING.md", *(f for d in folders for f in d.rglob("*.py"))]
    text = "\n".join(file.read_text("utf-8") for file in files)
    told = re.findall(r"pip install (?:-\w+ )*['\"]?([\w.-]+)", text)
    assert len(told) >= 8 and {*told} <= {"weftex", "."}
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    assert [project["name"], *project["scripts"]] == ["weftex", "weftex"]


def test_nothing_left_over_is_here():
    """What editors and merges leave behind beside a file."""
    folders = [ROOT / name for name in ("src", "tests", "docs", "examples", "benchmarks")]
    files = [file for folder in folders for file in folder.rglob("*")]
    assert [str(file) for file in files if re.search(r"\.(orig|rej|bak)$|~$", file.name)] == []
