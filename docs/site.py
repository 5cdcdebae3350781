"""For mkdocs: links that leave docs/ work on the site as they do in the repository.

Every file outside that a page leads to becomes a page under repository/, as it is or as code. A
reference that a line of a page leads to is printed below the line. The pages of methods list their
parameters, and the page of commands their help.
"""

from __future__ import annotations

import ast
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

from mkdocs.structure.files import File

ROOT = Path(__file__).parent.parent
DOCS = ROOT / "docs"
LINK = re.compile(r"(\]\(|(?:src|href)=\")([^)#\s\"]+)([^)\"]*)")
CODE = re.compile(r"^```.*?^```$|``.*?``|`[^`\n]+`", re.M | re.S)
#: A line that is a link to a reference.
REFERENCE = re.compile(r"^\[`\w+`\]\((?:\.\./)+(src/weftex/reference/\w+\.py)\)$", re.M)
#: Pages about the project that are always there.
PROJECT = ("CHANGELOG.md", "CONTRIBUTING.md", "SECURITY.md")

made: dict[str, Path] = {}  # pages of the site, by their place in it, that lie outside docs/


def target_of(link: str, origin: Path) -> Path | None:
    """The file that a relative link leads to."""
    if "://" in link or link.startswith(("mailto:", "data:", "/")):
        return None
    target = Path(os.path.normpath(origin.parent / link))
    return target if target.exists() and target.is_relative_to(ROOT) else None


def place_of(target: Path) -> str:
    """Where a file is on the site."""
    if target.is_relative_to(DOCS):
        return target.relative_to(DOCS).as_posix()
    return f"repository/{target.relative_to(ROOT).as_posix()}.md"


def text_of(target: Path) -> str:
    """What the page of a file outside docs/ says."""
    name = target.relative_to(ROOT).as_posix()
    if target.is_dir():
        files = sorted(p.name for p in target.iterdir() if not p.name.startswith(("_", ".")))
        return f"# {name}\n\n" + "".join(f"* `{file}`\n" for file in files)
    text = target.read_text("utf-8")
    if target.suffix == ".md":
        return text
    hidden = "---\nsearch: { exclude: true }\n---\n"
    kind = {".py": "python", ".json": "json"}.get(target.suffix, "text")
    return f"{hidden}# {name}\n\n````{kind}\n{text.rstrip()}\n````\n"


def outside(text: str, origin: Path) -> set[Path]:
    """Files outside docs/ that a page leads to."""
    links = {link for _, link, _ in LINK.findall(CODE.sub("", text))}
    found = {target_of(link, origin) for link in links}
    return {target for target in found if target is not None and not target.is_relative_to(DOCS)}


def on_files(files: Any, config: Any) -> Any:
    """Add the pages outside docs/ that others lead to, and those that they lead to."""
    made.clear()
    waiting = [ROOT / name for name in PROJECT]
    for page in DOCS.rglob("*.md"):
        waiting += outside(page.read_text("utf-8"), page)
    while waiting:
        target = waiting.pop()
        place = place_of(target)
        if place in made:
            continue
        made[place] = target
        text = text_of(target)
        files.append(File.generated(config, place, content=text))
        if target.suffix == ".md":
            waiting += outside(text, target)
    return files


def source_of(text: str) -> str:
    """What a module defines, with only the first lines of long docstrings."""
    lines, tree = text.splitlines(), ast.parse(text)
    said = [node.body[0] for node in tree.body if isinstance(node, ast.FunctionDef | ast.ClassDef)]
    for docstring in reversed(said):
        if isinstance(docstring, ast.Expr) and (docstring.end_lineno or 0) > docstring.lineno + 3:
            lines[docstring.lineno - 1 : docstring.end_lineno] = [
                lines[docstring.lineno - 1] + '"""'
            ]
    imports = [n for n in tree.body if isinstance(n, ast.Import | ast.ImportFrom)]
    return "\n".join(lines[imports[-1].end_lineno :]).strip("\n")


def parameters(slug: str) -> str:
    """The list of a method's parameters."""
    from weftex.cli.arguments import parameters_of
    from weftex.registry import method_class

    lines = [
        f"* **`{field.name}`**: {field.metadata['help']}. *{values[0].upper()}{values[1:]}.*\n"
        for field, values in parameters_of(method_class(slug))
    ]
    return f"{''.join(lines)}\n"


def help_of(*words: str) -> str:
    """What `weftex WORDS --help` prints."""
    command = [sys.executable, "-m", "weftex", *words, "--help"]
    wide = os.environ | {"COLUMNS": "100"}
    return subprocess.run(command, env=wide, capture_output=True, text=True, check=True).stdout


def commands() -> str:
    """A section for each command, with its help."""
    names = re.findall(r"^  (\w+) {2,}", help_of(), re.M)
    return "".join(f"\n## {name}\n\n```text\n{help_of(name)}```\n" for name in names)


def on_page_markdown(markdown: str, page: Any, config: Any, files: Any) -> str:
    """Turn links to files into links to the pages that they became."""
    here = page.file.src_uri
    if here == "reference/commands.md":
        markdown += commands()
    if here.startswith("reference/methods/") and not here.endswith("index.md"):
        slug = Path(here).stem
        markdown = markdown.replace(f"`weftex methods {slug}` lists them.\n", parameters(slug))
    origin = made.get(here, DOCS / here)
    markdown = REFERENCE.sub(
        lambda found: (
            f"{found[0]}\n\n```python\n{source_of((ROOT / found[1]).read_text('utf-8'))}\n```"
        ),
        markdown,
    )

    def turned(found: re.Match[str]) -> str:
        target = target_of(found[2], origin)
        if target is None:
            return found[0]
        link = os.path.relpath(place_of(target), os.path.dirname(here) or ".")
        return f"{found[1]}{Path(link).as_posix()}{found[3]}"

    parts, end = [], 0
    for code in CODE.finditer(markdown):  # what is code stays
        parts += [LINK.sub(turned, markdown[end : code.start()]), code[0]]
        end = code.end()
    return "".join([*parts, LINK.sub(turned, markdown[end:])])
