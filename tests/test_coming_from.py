"""The models of docs/coming-from.md have the results given beside them, and the names of mecano there exist."""

import re
from pathlib import Path

import pytest

import mecano
from mecano.cli import commands
from mecano.deck.describe import inner_fields
from mecano.deck.expanded_sections import EXPANDED_SECTIONS
from mecano.deck.sections import SECTIONS
from mecano.elements import KINDS
from mecano.laws import TERMS

TEXT = (Path(__file__).parent.parent / "docs" / "coming-from.md").read_text(encoding="utf-8")
FALLING, CANTILEVER, DRIVEN = re.findall(r"^```yaml\n(.*?)^```", TEXT, re.DOTALL | re.MULTILINE)
VALUES = {"true", "hht", "radau", "ground"}


def solved(deck, folder):
    (folder / "deck.yaml").write_text(deck)
    return mecano.run(folder / "deck.yaml", folder / "deck.h5", quiet=True)


def test_the_mass_on_a_spring_and_damper(tmp_path):
    """Overshoot of a damped oscillator: m = 2, k = 800, c = 4, so a decay of 1/s and 19.975 rad/s."""
    with solved(FALLING, tmp_path) as results:
        extreme = results.extremes["joints/guide/displacement"]
    assert extreme.minimum == pytest.approx(-0.0454808, rel=1e-5)  # -m g/k (1 + exp(-pi/19.975))
    assert extreme.minimum_time == pytest.approx(0.157276, abs=5e-4)  # pi/19.975, at a step of 1 ms
    assert "-45.5 mm after 0.157 s" in TEXT


def test_the_cantilever(tmp_path):
    with solved(CANTILEVER, tmp_path) as results:
        sag = results["tip.position.z"].values[-1]
    bending = 0.1 * 0.5**3 / (3 * 70e9 * 0.03 * 0.003**3 / 12)
    assert sag == pytest.approx(-bending, rel=1e-4)  # with shear, less the shortening of large rotation: 2e-5
    assert f"{1e3 * bending:.3f} mm" in TEXT


def test_the_program_that_builds_a_model(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    [code] = re.findall(r"^```python\n(.*?)^```", TEXT, re.DOTALL | re.MULTILINE)
    exec(code, {})
    assert float(capsys.readouterr().out) == pytest.approx(1.0, rel=1e-9)  # M t^2/(2 J)


def test_the_motor_with_an_eccentric_load(tmp_path):
    with solved(DRIVEN, tmp_path) as results:
        extreme = results.extremes["joints/motor/moment"]
    assert max(extreme.maximum, -extreme.minimum) == pytest.approx(3 * 9.81 * 0.2, rel=1e-9)  # at the start
    assert min(extreme.maximum, -extreme.minimum) == pytest.approx(3 * 9.81 * 0.2, rel=1e-5)  # half a step beside it
    assert "±5.886 N m" in TEXT


def names_of(sections):
    """Yield the names of fields and of those inside them."""
    for field in sections:
        yield field.name
        yield from names_of(inner_fields(field.type))


def test_names_of_mecano_exist():
    fields = {name for kind in KINDS.values() for name in names_of(kind.fields)}
    known = {*KINDS, *TERMS, *fields, *names_of(SECTIONS), *(item.name for item in EXPANDED_SECTIONS), *VALUES}
    rows = [line.strip("| ").split(" | ") for line in TEXT.splitlines() if re.match(r"\| (?!mecano|---)", line)]
    rows = [row for row in rows if row[1] not in ("mecano", "---")]
    assert len(rows) > 60
    for words in (word for _, right in rows for word in re.findall("`(.+?)`", right)):
        program, _, rest = words.partition(" ")
        if program == "mecano":
            command = commands.commands[rest.split()[0]]
            assert all(any(option in p.opts for p in command.params) for option in rest.split()[1:]), words
        elif words.startswith("mecano."):
            assert hasattr(mecano, words.removeprefix("mecano.")), words
        else:
            assert set(re.findall(r"[a-z_]+", words)) <= known or words == "$length / 2", words
