"""What is packed: the source archive has what a build and its tests need, and no more."""

import re
import subprocess
import sys
import tarfile
import tomllib
from pathlib import Path

import pytest

import weftex

ROOT = Path(__file__).parent.parent
#: Tests of what stays in the repository.
_OURS = "benchmarks fidelity fuzz gallery notebooks packaging readme words".split()  # noqa: SIM905
STAY = {"tests/fidelity.toml", "tests/words.toml", *(f"tests/test_{name}.py" for name in _OURS)}
_KINDS = "py pxd typed png csv json html css js svg toml usda gdshader gltf tres tsx"
SUFFIXES = {f".{kind}" for kind in _KINDS.split()}


def under(*folders):
    """Files of the repository that are no leftovers of builds."""
    files = (p for folder in folders for p in (ROOT / folder).rglob("*") if p.suffix in SUFFIXES)
    return {p.relative_to(ROOT).as_posix() for p in files if "__pycache__" not in p.parts}


@pytest.mark.pages
def test_the_source_archive(tmp_path):
    command = [sys.executable, "setup.py", "-q", "egg_info", "--egg-base", tmp_path, "sdist"]
    subprocess.run([*command, "-d", tmp_path], cwd=ROOT, check=True, capture_output=True)
    (archive,) = tmp_path.glob("*.tar.gz")
    with tarfile.open(archive) as packed:
        files = {m.name.split("/", 1)[1] for m in packed.getmembers() if m.isfile()}
    files = {file for file in files if ".egg-info/" not in file}
    tools = {file for file in under("benchmarks") if re.search(r"\.py$|/judged/", file)}
    wanted = (under("src", "examples", "tests") | tools) - STAY
    about = {"CHANGELOG.md", "LICENSE", "MANIFEST.in", "PKG-INFO", "README.md", "setup.cfg"}
    about |= {"pyproject.toml", "setup.py", "benchmarks/quality/judged/README.md"}
    assert files == wanted | about
    assert archive.name == f"weftex-{weftex.__version__}.tar.gz"
    assert archive.stat().st_size < 4_000_000


def test_what_is_said_about_the_project_agrees():
    """In the files that packagers and readers take it from."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    recipe = (ROOT / "recipe" / "recipe.yaml").read_text("utf-8").lower()
    for need in project["dependencies"]:
        assert re.sub(r">=", " >=", need.lower()) in recipe, need
    assert f'version: "{weftex.__version__}"' in recipe
    citation = (ROOT / "CITATION.cff").read_text("utf-8")
    assert f"version: {weftex.__version__}\n" in citation
    papers = (ROOT / "docs" / "background" / "papers.md").read_text("utf-8")
    assert re.findall(r"doi.org/(\S+?)\)", papers) == re.findall(r" doi: (\S+)", citation) != []
    cited = re.findall(r'- type: \w.*\n    title: "(.*)"', citation)
    assert len(cited) >= 10 and all(title in papers for title in cited)
    switches = re.findall(r"WEFTEX_[A-Z]+", (ROOT / "CONTRIBUTING.md").read_text("utf-8"))
    assert {"WEFTEX_CHECKS", "WEFTEX_SANITIZE"} <= {*switches}
    assert all(f'"{switch}"' in (ROOT / "setup.py").read_text("utf-8") for switch in switches)
    assert f"\n## {weftex.__version__}" in (ROOT / "CHANGELOG.md").read_text("utf-8")
    for workflow in (ROOT / ".github" / "workflows").glob("*.yml"):
        for action in re.findall(r"uses: (\S+.*)", workflow.read_text("utf-8")):
            assert re.fullmatch(r"[\w/.-]+@[0-9a-f]{40} # v[\d.]+", action), action
