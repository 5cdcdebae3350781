"""The pages of fidelity leave out no figure of a paper, and what they name is there and runs."""

import ast
import functools
import re
import shlex
import tomllib
from pathlib import Path
from typing import NamedTuple

import pytest

import weftex
from commands import weft_run
from test_readme import EXAMPLES, experiments

ROOT = Path(__file__).parent.parent
SOURCE = ROOT / "src" / "weftex"
PAGES = {page.stem: page for page in ROOT.glob("docs/background/fidelity/*.md")}
PROMISE = "](../fidelity.md)"  # a link to what the columns mean


def numbered(chapter, last):
    return [f"{chapter}.{k}" for k in range(1, last + 1)]


def up_to(last):
    return [str(k) for k in range(1, last + 1)]


#: Numbers of all figures of each paper, and of all tables.
FIGURES = {
    "patch-based-sampling": up_to(17),
    "non-parametric-sampling-and-tsvq": up_to(3),
    "exact-neighborhood-matching": up_to(13),
    "refinement-and-fusion": up_to(13),
    "near-regular": [
        *numbered(1, 2), *numbered(2, 10), *numbered(3, 7), *numbered(4, 13), *numbered(5, 17)
    ],
}  # fmt: skip
TABLES = {
    "patch-based-sampling": ["I"],
    "exact-neighborhood-matching": ["1"],
    "refinement-and-fusion": ["1"],
}
REQUIRED = tomllib.loads((ROOT / "tests" / "fidelity.toml").read_text("utf-8"))


class Row(NamedTuple):
    """The four columns."""

    place: str
    weftex: str
    different: str
    proof: str


def rows(page):
    """Rows of all tables of a page, without their heads."""
    lines = [line for line in page.read_text("utf-8").splitlines() if line.startswith("|")]
    cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]
    found = [Row(*four) for four in cells if set("".join(four)) != {"-"} and four[0] != "paper"]
    assert len(found) >= 3
    return found


ROWS = [(name, row) for name, page in sorted(PAGES.items()) for row in rows(page)]
NAMES = [f"{name}: {row.place[:50]}" for name, row in ROWS]
TESTS = {path.name: path for path in ROOT.glob("tests/**/test_*.py")}
COMMANDS = sorted({one for _, row in ROWS for one in re.findall("`(weftex [^`]+)`", row.proof)})


def counted(text, kinds):
    """Numbers named after one of the words, as in "Figs. 2.2, 2.3 and 5.13 to 5.17"."""
    found = []
    number = r"(?:\d+(?:\.\d+)?|I)\b"
    for names in re.findall(rf"(?:{kinds}) ({number}(?:(?:, | and | to ){number})*)", text):
        words = re.split(", | and ", names)
        for word in words:
            first, _, last = word.partition(" to ")
            chapter, _, start = first.rpartition(".")
            stop = last.rpartition(".")[2] or start
            if start.isdigit():
                ends = range(int(start), int(stop) + 1)
                found += [f"{chapter}.{k}" if chapter else str(k) for k in ends]
            else:
                found.append(first)
    return found


def test_numbers_are_read():
    text = "Fig. 3 (b), Figs. 5 and 6; Figs. 2.2, 2.3 and 5.13 to 5.15, Table I"
    assert counted(text, "Fig.|Figs.") == ["3", "5", "6", "2.2", "2.3", "5.13", "5.14", "5.15"]
    assert counted(text, "Table|Tables") == ["I"]


@pytest.mark.parametrize("name", sorted(FIGURES))
def test_every_figure_and_table_has_a_row(name):
    places = "\n".join(row.place for row in rows(PAGES[name]))
    for kinds, numbers in ((r"Figs?\.", FIGURES[name]), ("Tables?", TABLES.get(name, []))):
        found = counted(places, kinds)
        assert [number for number in numbers if number not in found] == []
        assert set(found) <= set(numbers)


@pytest.mark.parametrize("name", sorted(REQUIRED))
def test_every_application_and_future_work_has_a_row(name):
    places = [row.place for row in rows(PAGES[name])]
    for words in REQUIRED[name]["named"]:
        assert any(words in place for place in places), words


def test_pages_are_found_and_lead_back():
    index = ROOT.joinpath("docs", "background", "fidelity.md").read_text("utf-8")
    assert set(FIGURES) < set(PAGES)
    for name, page in PAGES.items():
        assert f"](fidelity/{name}.md)" in index and PROMISE in page.read_text("utf-8")


@functools.cache
def functions(file):
    """Names of what a file defines."""
    body = ast.parse(file.read_text("utf-8")).body
    return {node.name for node in body if isinstance(node, ast.FunctionDef)}


@pytest.mark.parametrize("row", [row for _, row in ROWS], ids=NAMES)
def test_rows_are_whole(row):
    """What is here has a proof, what is not has a reason; proofs and files that are named exist."""
    missing = row.weftex in ("not here", "not drawn yet")
    assert row.place and (missing or row.proof), row
    assert row.different or row.proof or row.weftex == "not drawn yet", row
    for name, test in re.findall(r"`(test_\w+\.py)::(test_\w+)`", row.proof):
        assert test in functions(TESTS[name]), test
    for script, experiment in re.findall(r"`examples/((?:papers/)?\w+\.py)(?: (\w+))?`", row.proof):
        path = ROOT / "examples" / script
        assert experiment in experiments(path) if experiment else path in EXAMPLES
    rest = re.sub(
        r"`(test_\w+\.py::test_\w+|examples/[\w/]+\.py( \w+)?|weftex [^`]+)`", "", row.proof
    )
    assert "`" not in rest and not re.search(r"\w\.py", rest), f"not a proof: {rest}"
    for file in re.findall(r"`([\w/]+\.py)`", row.weftex + row.different):
        assert (SOURCE / file).exists(), file


STATED = [(name, *row) for name, page in REQUIRED.items() for row in page["stated"].items()]


def number_of(file_or_method, name):
    """The constant of a file, of a kernel too, or the default of a method's parameter."""
    if not file_or_method.endswith(".py"):
        return getattr(weftex.METHODS[file_or_method], name)
    line = re.search(rf"^{name} = (.*)$", (SOURCE / file_or_method).read_text("utf-8"), re.M)[1]
    value = re.sub(r"cython.declare\([\w.]+, (.*)\)", r"\1", line.partition("  #")[0])
    return eval(value, {})


@pytest.mark.parametrize(("name", "phrase", "where"), STATED, ids=[words[1] for words in STATED])
def test_stated_numbers_are_those_of_the_code(name, phrase, where):
    number = number_of(*where.split())
    number = int(number) if number == int(number) else number
    assert phrase.format(number) in PAGES[name].read_text("utf-8"), number


@pytest.mark.pages
@pytest.mark.parametrize("command", COMMANDS)
def test_commands_run(command, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    words = shlex.split(command)[1:]
    assert weft_run(*words) == 0
    assert "-o" not in words or Path(words[words.index("-o") + 1]).exists()
