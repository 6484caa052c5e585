"""Metadata of the package are consistent, and the wheel is complete."""

import tomllib
from pathlib import Path

import pytest
import yaml

import mecano
from mecano.deck.check import VERSION as DECKS
from mecano.results.layout import FORMAT_VERSION
from mecano.study.grammar import VERSION as STUDIES

ROOT = Path(__file__).parent.parent
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
RECIPE = yaml.safe_load((ROOT / "docs/packaging/recipe.yaml").read_text(encoding="utf-8"))
CITATION = yaml.safe_load((ROOT / "docs/CITATION.cff").read_text(encoding="utf-8"))


def test_versions_agree():
    assert RECIPE["package"]["version"] == CITATION["version"] == mecano.__version__
    changelog = (ROOT / "docs/changelog.md").read_text(encoding="utf-8")
    assert f"## {mecano.__version__} " in changelog
    for version in (f"`mecano: {DECKS}`", f"`study: {STUDIES}`", f"`format_version`, {FORMAT_VERSION},"):
        assert version in changelog


def test_the_conda_recipe_requires_the_dependencies_of_pip():
    renamed = {"matplotlib-base": "matplotlib"}
    bounds = dict(line.split() for line in RECIPE["requirements"]["run"])
    python = bounds.pop("python")
    assert python == PROJECT["requires-python"]
    assert {renamed.get(name, name) + bound for name, bound in bounds.items()} == set(PROJECT["dependencies"])
    assert RECIPE["build"]["python"]["entry_points"] == [f"mecano = {PROJECT['scripts']['mecano']}"]
    assert RECIPE["about"]["summary"] == PROJECT["description"]


def test_one_licence_is_named_everywhere():
    [file] = PROJECT["license-files"]
    assert PROJECT["license"] == RECIPE["about"]["license"] == CITATION["license"] == "MIT"
    assert RECIPE["about"]["license_file"] == file and (ROOT / file).read_text().startswith("MIT License")


@pytest.mark.parametrize("name", ["Dockerfile", "mecano.def"])
def test_images_copy_files_that_exist(name):
    lines = [line.split() for line in (ROOT / "docs/packaging" / name).read_text().splitlines()]
    copied = [word for words in lines if words[:1] == ["COPY"] and "--from" not in words[1] for word in words[1:-1]]
    copied += [words[0] for words in lines if len(words) == 2 and words[1].startswith("/clone/")]
    assert {"pyproject.toml", "README.md", "docs/LICENSE", "inputs", "mecano"} == set(copied)
    assert all((ROOT / path).exists() for path in copied)
