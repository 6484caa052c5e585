"""The benchmarks of tests/benchmarks run: a few steps of mecano alone."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

RUN = Path(__file__).parent / "benchmarks" / "run.py"


@pytest.mark.parametrize("case", ["chain-1", "four-bar-10", "gear-drop", "rolling-disc"])
def test_a_case_runs(case):
    options = ["--json", "--mecano-only", "--steps", "40", "--repetitions", "1"]
    ended = subprocess.run([sys.executable, RUN, case, *options], capture_output=True, text=True, check=True)
    found = json.loads(ended.stdout)
    assert (found["case"], found["steps"]) == (case, 40) and "exudyn" not in found and "ratio" not in found
    steps, iterations = found["mecano"]["counts"]
    assert 40 <= steps <= 45 and iterations >= steps  # touch-downs cut steps
    assert 0.5 < found["mecano"]["us_per_step"] < 1e5
    assert 0.0 < found["mecano"]["error"] < 1e-2


def test_the_startup_is_measured():
    command = [sys.executable, RUN, "startup", "--repetitions", "1"]
    ended = subprocess.run(command, capture_output=True, text=True, check=True)
    seconds, unit = ended.stdout.split()
    assert 0.2 < float(seconds) < 20.0 and unit == "s"


def test_without_a_case_it_says_which_there_are():
    ended = subprocess.run([sys.executable, RUN, "chain"], capture_output=True, text=True)
    assert ended.returncode == 2 and "'chain-100'" in ended.stderr


def test_the_mast_is_measured():
    command = [sys.executable, RUN.with_name("mast.py"), "500"]
    said = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    assert said.strip().startswith("540 unknowns: prepared in ") and "100 steps of" in said and "0 unstable" in said


def test_tables_are_written_between_their_marks(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(str(RUN.parent))
    import tables

    page, readme = tmp_path / "page.md", tmp_path / "README.md"
    page.write_text("a\n<!-- cases -->\nold\n<!-- end of cases -->\nb\n<!-- beams -->\n<!-- end of beams -->\nc\n")
    readme.write_text("| case | x |\n| chain-1: one | old |\n")
    monkeypatch.setattr(tables, "PAGE", page)
    monkeypatch.setattr(tables, "README", readme)
    monkeypatch.setattr(tables, "_measured", lambda: "today\n")
    code = {"us_per_step": 2.0, "error": 1e-5}
    case = {"case": "chain-1", "words": "one", "required": 0.5, "ratio": 0.5, "mecano": code, "exudyn": code}
    beam = {"elements": 8, "us_per_step": 22.4, "error": 1e-4, "element": "exact beam"}
    tables.write([{**case, "at_errors": [], "equal_accuracy": {"ratio": 0.25}}], [beam])
    row = "| chain-1: one | 2.0 | 1.0e-05 | 2.0 | 1.0e-05 | 0.50 |"
    text = page.read_text()
    assert f"{row} 0.25 | 0.5 |" in text and "old" not in text and "| 8 | 22.4 | 1.0e-04 | exact beam | no" in text
    assert text.startswith("a\n") and "\nb\n" in text and text.endswith("\nc\n")
    assert readme.read_text() == f"| case | x |\n{row}\n"
