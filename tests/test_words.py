"""The documentation uses the field's words; words.toml lists the others, with what to write."""

import ast
import re
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
PAGES = sorted([
    *(ROOT / name for name in ("README.md", "CHANGELOG.md", "CONTRIBUTING.md", "SECURITY.md")),
    *(p for p in ROOT.glob("docs/**/*.md") if "lab" not in p.relative_to(ROOT).parts),
])  # fmt: skip
RULES = {
    re.compile(rf"(?<!\w)(?:{pattern})(?!\w)", re.I): better
    for rules in tomllib.loads((ROOT / "tests" / "words.toml").read_text("utf-8")).values()
    for pattern, better in rules.items()
}
#: What is not prose: fenced and indented code, spans of code, targets of links, HTML.
CODE = re.compile(r"^```.*?^```$|^ {4}\S[^\n]*$|`[^`\n]+`|\]\([^)]*\)|<[^>\n]+>", re.M | re.S)


def found(text):
    """The words of a text that break a rule, each with its line and what to write."""
    return [
        f"line {text.count(chr(10), 0, hit.start()) + 1}: {hit[0]!r}; write: {better}"
        for rule, better in RULES.items()
        for hit in rule.finditer(text)
    ]


def prose(page):
    """A page without code; as many lines as it has."""
    return CODE.sub(lambda code: re.sub(r"[^\n]", " ", code[0]), page.read_text("utf-8"))


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_words_of_pages(page):
    assert found(prose(page)) == []


def test_rules_find_words():
    assert found("It hangs on the grey sample.")[0].startswith("line 1: 'hangs on'")
    assert len(found("It hangs on the grey sample.")) == 2
    assert found("It depends on the gray sample.") == []


def help_of(module):
    """Texts that a module prints, and the first lines of its docstrings, with lines."""
    for node in ast.walk(ast.parse(module.read_text("utf-8"))):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef):
            docstring = ast.get_docstring(node) or ""
            yield getattr(node, "lineno", 1), docstring.partition("\n")[0]
        if isinstance(node, ast.Call):  # help, refusals, notes: sentences have spaces
            for part in [p for one in (*node.args, *node.keywords) for p in ast.walk(one)]:
                if isinstance(part, ast.Constant) and str(part.value).count(" ") > 2:
                    yield part.lineno, str(part.value)


def src():
    """Lines of the sources that break a rule."""
    for module in sorted((ROOT / "src").rglob("*.py")):
        for line, text in help_of(module):
            for hit in found(re.sub(r"`[^`]+`", "", text)):
                yield f"{module.relative_to(ROOT)}:{line}: {hit.partition(': ')[2]}"


def test_words_of_help_and_docstrings():
    assert list(src()) == []
