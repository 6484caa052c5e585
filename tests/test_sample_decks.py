"""`mecano new`: starter decks, each of which runs; `mecano schema`."""

import json

import pytest
from click.testing import CliRunner

import mecano
from mecano.analyses.prepare import prepare
from mecano.cli import commands
from mecano.deck.new_file import write_text
from mecano.deck.read import read_deck
from mecano.deck.sample_decks import examples, starter, starters, write_example
from mecano.errors import ResultsError, UsageError
from mecano.model.sampler import Sampler, row_size


@pytest.mark.parametrize("name", starters())
def test_starters_run(name, tmp_path):
    """The first steps; the whole of them is run by hand, without a message."""
    path = tmp_path / f"{name}.yaml"
    write_text(path, starter(name))
    deck = read_deck(path)
    prepared = prepare(deck)
    assert deck.values["title"] and prepared.displacement < 1e-12
    assert row_size(prepared.system) == Sampler(prepared.system).row.size
    results = tmp_path / "results.h5"
    short = (
        [] if deck.values["static"] else ["time.end=0.01", "time.adaptive=null", "time.step=1e-3", "output.every=step"]
    )
    if deck.values["static"]:
        from mecano.analyses.static import run
    else:
        from mecano.analyses.dynamic import run
    run(read_deck(path, short), str(results))
    with mecano.open_results(results) as found:
        assert found.status == "complete"
        if name == "beam":  # F L^3/(3 E I) = 7.634 mm, and the shear
            assert found["tip.position.z"].values[-1] == pytest.approx(-7.65e-3, rel=5e-3)


def test_new_lists_writes_and_replaces_nothing(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    listed = CliRunner().invoke(commands, ["new"], catch_exceptions=False).output
    assert "pendulum      A pendulum: one body on one hinge" in listed
    written = CliRunner().invoke(commands, ["new", "pendulum"], catch_exceptions=False)
    assert written.exit_code == 0 and (tmp_path / "pendulum.yaml").read_text() == starters()["pendulum"]
    (tmp_path / "pendulum.yaml").write_text("mine")
    with pytest.raises(UsageError, match="pendulum.yaml already exists and is not replaced"):
        CliRunner().invoke(commands, ["new", "pendulum"], catch_exceptions=False)
    assert (tmp_path / "pendulum.yaml").read_text() == "mine"
    with pytest.raises(UsageError, match="there is no deck 'pendulm' to begin with; did you mean 'pendulum'?"):
        CliRunner().invoke(commands, ["new", "pendulm"], catch_exceptions=False)
    with pytest.raises(ResultsError, match="none/a.yaml cannot be written: No such file or directory"):
        CliRunner().invoke(commands, ["new", "beam", "none/a.yaml"], catch_exceptions=False)


def test_decks_are_written_into_a_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for words in (["new", "beam", str(tmp_path)], ["example", "superelement_arm", "."]):
        assert CliRunner().invoke(commands, words, catch_exceptions=False).exit_code == 0
    assert {path.name for path in tmp_path.iterdir()} == {"beam.yaml", "superelement_arm.yaml", "superelement_arm.npz"}


@pytest.mark.parametrize(("command", "hint"), [("new", "mecano run pendulum.yaml -o r.h5"), ("example", "-o r.h5")])
def test_decks_are_not_written_into_files_of_results(command, hint, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(UsageError, match=f"a deck is YAML, not '.h5': .*{hint}"):
        commands([command, "pendulum", "r.h5"], standalone_mode=False)
    assert not list(tmp_path.iterdir())


def test_schema_is_written(tmp_path):
    path = tmp_path / "mecano.schema.json"
    printed = CliRunner().invoke(commands, ["schema"], catch_exceptions=False).output
    for _ in range(2):
        CliRunner().invoke(commands, ["schema", "-o", str(path)], catch_exceptions=False)
    assert json.loads(printed) == json.loads(path.read_text())


@pytest.mark.parametrize("name", examples())
def test_examples_are_read_where_they_are_written(name, tmp_path):
    """What an example reads lies beside it, and its list has a title for it."""
    write_example(name, tmp_path / "deck.yaml")
    assert read_deck(tmp_path / "deck.yaml").values["title"]


def test_an_example_and_what_it_reads_are_written_but_never_over_other_files(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "superelement_arm.npz").write_bytes(b"of the user")
    refused = CliRunner().invoke(commands, ["example", "superelement_arm"])
    assert "superelement_arm.npz already exists" in str(refused.exception)
    assert (tmp_path / "superelement_arm.npz").read_bytes() == b"of the user"
    (tmp_path / "superelement_arm.npz").unlink()
    for deck in ("first.yaml", "second.yaml"):  # the second finds the matrices of the first
        done = CliRunner().invoke(commands, ["example", "superelement_arm", deck])
        assert done.exit_code == 0 and "mecano run " + deck in done.output
    with pytest.raises(UsageError, match="no example 'pendulun'; did you mean 'pendulum'"):
        write_example("pendulun", "deck.yaml")
    with pytest.raises(UsageError, match="`mecano example` lists them"):
        write_example("nothing alike", "deck.yaml")
    with pytest.raises(UsageError, match="mecano example nose_gear_rigid"):
        starter("nose_gear_rigid")


def test_the_lists_name_every_starter_and_example():
    listed = CliRunner().invoke(commands, ["new", "--list"]).output
    assert all(f"  {name} " in listed for name in (*starters(), *examples()))
    assert CliRunner().invoke(commands, ["example"]).output in listed
