"""The notebooks run from the first cell to the last, and are kept with small outputs."""

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
def test_notebooks_run(path, tmp_path, monkeypatch, capsys):
    """Each cell as IPython runs it; it prints what is stored, and its last value can be shown."""
    monkeypatch.chdir(tmp_path)
    names = {"__name__": "__main__"}
    for cell in cells_of(path, "code"):
        tree = ast.parse("".join(cell["source"]))
        last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
        exec(compile(tree, path.name, "exec"), names)
        stored = ["".join(one["text"]) for one in cell["outputs"] if "text" in one]
        assert capsys.readouterr().out == "".join(stored)
        if last is not None:
            shown = eval(compile(ast.Expression(last.value), path.name, "eval"), names)
            assert shown is None or repr(shown)
            if hasattr(shown, "_repr_html_"):
                assert "<img" in shown._repr_html_()


def test_notebooks_have_small_outputs_and_use_public_names():
    """`benchmarks/pages/notebooks.py` writes the outputs."""
    assert len(NOTEBOOKS) == 2
    for path in NOTEBOOKS:
        assert len(cells_of(path, "markdown")) > 3 and path.stat().st_size < 200_000
        code = cells_of(path, "code")
        assert [cell["execution_count"] for cell in code] == [*range(1, len(code) + 1)]
        for cell in code:
            tree = ast.parse("".join(cell["source"]))
            loaded = [a.name for n in ast.walk(tree) if isinstance(n, ast.Import) for a in n.names]
            assert {*loaded} <= {"weftex", "numpy"}
            assert not any(isinstance(node, ast.ImportFrom) for node in ast.walk(tree))
            assert bool(cell["outputs"]) == isinstance(tree.body[-1], ast.Expr)
