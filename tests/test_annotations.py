"""Public functions of the folders that mypy checks carry types (``files`` of [tool.mypy] in pyproject.toml)."""

import ast
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
CHECKED = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["mypy"]["files"]


def public_functions(body, owner=""):
    """Yield (dotted name, node, is_method) of the functions and methods in a list of statements."""
    for statement in body:
        if isinstance(statement, ast.ClassDef) and not statement.name.startswith("_"):
            yield from public_functions(statement.body, f"{owner}{statement.name}.")
        elif isinstance(statement, ast.FunctionDef | ast.AsyncFunctionDef):
            if not statement.name.startswith("_") or statement.name == "__init__":
                yield owner + statement.name, statement, owner != ""


def without_type(function, is_method):
    """Return the names of the parameters without a type, and "result"; the result of __init__ needs none."""
    given = function.args
    decorators = {decorator.id for decorator in function.decorator_list if isinstance(decorator, ast.Name)}
    parameters = [*given.posonlyargs, *given.args][is_method and "staticmethod" not in decorators :]
    parameters += [*given.kwonlyargs, *filter(None, (given.vararg, given.kwarg))]
    missing = [parameter.arg for parameter in parameters if parameter.annotation is None]
    return missing if function.returns or function.name == "__init__" else [*missing, "result"]


@pytest.mark.parametrize("path", CHECKED)
def test_public_functions_carry_types(path):
    files = sorted((ROOT / path).rglob("*.py")) if (ROOT / path).is_dir() else [ROOT / path]
    found = {
        f"{file.relative_to(ROOT)}: {name}": missing
        for file in files
        for name, function, is_method in public_functions(ast.parse(file.read_text(encoding="utf-8")).body)
        if (missing := without_type(function, is_method))
    }
    assert files and not found


def test_missing_types_are_found():
    source = (
        "def f(a, *, b: int = 1) -> int: ...\nclass C:\n    def __init__(self, a: int): ...\n    def g(self): ...\n"
    )
    found = [
        (name, without_type(function, is_method))
        for name, function, is_method in public_functions(ast.parse(source).body)
    ]
    assert found == [("f", ["a"]), ("C.__init__", []), ("C.g", ["result"])]
