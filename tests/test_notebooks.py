"""The notebooks run from the first cell to the last, and are kept without outputs."""

import ast
import json
from pathlib import Path

import pytest

pytestmark = pytest.mark.pages
NOTEBOOKS = sorted((Path(__file__).parent.parent / "notebooks").glob("*.ipynb"))


def cells_of(path, kind):
    cells = json.loads(path.read_text("utf-8"))["cells"]
    return [cell for cell in cells if cell["cell_type"] == kind]


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebooks_run(path, tmp_path, monkeypatch):
    """Each cell as IPython runs it; what its last line gives must be able to show itself."""
    monkeypatch.chdir(tmp_path)
    names = {"__name__": "__main__"}
    for cell in cells_of(path, "code"):
        tree = ast.parse("".join(cell["source"]))
        last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
        exec(compile(tree, path.name, "exec"), names)
        if last is not None:
            shown = eval(compile(ast.Expression(last.value), path.name, "eval"), names)
            assert shown is None or repr(shown)
            if hasattr(shown, "_repr_html_"):
                assert "<img" in shown._repr_html_()


def test_notebooks_are_there_and_stripped():
    assert len(NOTEBOOKS) == 2
    for path in NOTEBOOKS:
        assert len(cells_of(path, "markdown")) > 3
        for cell in cells_of(path, "code"):
            assert cell["outputs"] == [] and cell["execution_count"] is None
