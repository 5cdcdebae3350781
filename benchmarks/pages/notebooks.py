"""Run the notebooks and keep their outputs, with small images:

python benchmarks/pages/notebooks.py
"""

from __future__ import annotations

import ast
import base64
import io
import json
import os
import tempfile
from contextlib import redirect_stdout
from pathlib import Path
from typing import Any

from PIL import Image

NOTEBOOKS = Path(__file__).parents[2] / "notebooks"
_SIDE = 256  # pixels of an image in a notebook, at most


def shown(value: Any) -> dict[str, Any]:
    """The output of a cell's last expression, by the types of its data."""
    data: dict[str, Any] = {"text/plain": [repr(value)]}
    if hasattr(value, "_repr_png_"):
        image = Image.open(io.BytesIO(value._repr_png_())).convert("RGB")
        image.thumbnail((_SIDE, _SIDE), Image.Resampling.LANCZOS)
        image.save(file := io.BytesIO(), "jpeg", quality=85)
        data["image/jpeg"] = base64.b64encode(file.getvalue()).decode()
    return data


def run(cell: dict[str, Any], names: dict[str, Any], number: int) -> None:
    """Run a cell as IPython does, and store what it printed and gave."""
    tree = ast.parse("".join(cell["source"]))
    last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
    cell["execution_count"], cell["outputs"], printed = number, [], io.StringIO()
    with redirect_stdout(printed):
        exec(compile(tree, "notebook", "exec"), names)
        value = None
        if last is not None:
            value = eval(compile(ast.Expression(last.value), "notebook", "eval"), names)
    if printed.getvalue():
        text = printed.getvalue().splitlines(keepends=True)
        cell["outputs"].append({"output_type": "stream", "name": "stdout", "text": text})
    if value is not None:
        result = {"output_type": "execute_result", "execution_count": number, "metadata": {}}
        cell["outputs"].append(result | {"data": shown(value)})


def main() -> None:
    """Run all notebooks in an empty folder."""
    os.chdir(tempfile.mkdtemp())
    for path in sorted(NOTEBOOKS.glob("*.ipynb")):
        notebook, names = json.loads(path.read_text("utf-8")), {"__name__": "__main__"}
        code = [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]
        for number, cell in enumerate(code, 1):
            run(cell, names, number)
        path.write_text(json.dumps(notebook, indent=1, ensure_ascii=False) + "\n", "utf-8")


if __name__ == "__main__":
    main()
