"""The notebooks of docs/notebooks run from top to bottom, and the values of their cells can be displayed.

The cells are run as plain Python: a kernel would only carry the code and what is shown between two processes.
"""

import ast
import json
from pathlib import Path

import pytest

NOTEBOOKS = sorted((Path(__file__).parent.parent / "docs" / "notebooks").glob("*.ipynb"))


def run(source, names):
    """Run the code of a cell; return the value of the expression with which it ends, or None."""
    body = ast.parse(source).body
    last = body.pop() if isinstance(body[-1], ast.Expr) else None
    exec(compile(ast.Module(body, []), "cell", "exec"), names)
    return last and eval(compile(ast.Expression(last.value), "cell", "eval"), names)


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_cells_run_and_are_shown(path, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    notebook, names, shown = json.loads(path.read_text(encoding="utf-8")), {}, set()
    for cell in notebook["cells"]:
        if cell["cell_type"] == "code":
            assert cell["outputs"] == [] and cell["execution_count"] is None, "clear the outputs before a commit"
            value = run("".join(cell["source"]), names)
            for form in ("_repr_html_", "_repr_png_"):
                if hasattr(value, form):
                    assert len(getattr(value, form)()) > 100
                    shown.add(form)
    assert "_repr_png_" in shown


def test_there_are_some():
    page = (Path(__file__).parent.parent / "docs" / "python.md").read_text(encoding="utf-8")
    assert len(NOTEBOOKS) >= 2 and all(f"(notebooks/{path.name})" in page for path in NOTEBOOKS)
