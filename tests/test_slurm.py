"""Studies and the scripts of docs/cluster.md in a real Slurm: `pytest -m slurm`, as root, some minutes."""

import os
import re
import stat
import subprocess
import sys
import time
from pathlib import Path

import pytest
import slurm
from process import COMMAND
from time_runs import INPUTS

import mecano
from mecano.errors import ResultsError
from mecano.results.study_file import read_study

pytestmark = [
    pytest.mark.slurm,
    pytest.mark.skipif(not slurm.available(), reason="no Slurm, or not root"),
]
PAGE = Path(__file__).parent.parent / "docs" / "cluster.md"
SCRIPTS = dict(
    (re.search(r"--job-name=(\w+)", text)[1], text)
    for text in re.findall(r"```bash\n(#!/bin/bash\n.*?)```", PAGE.read_text(), re.DOTALL)
)
LONG = {
    "end: 4.0": "end: 30.0",
    "adaptive: {tolerance: 1.0e-3, maximum_step: 0.01}": "adaptive: null",
}  # 300,000 steps, 14 s of processor time: enough to send a signal after the first of them
PATIENT = ("--time=60",)  # the minutes of the page do not suffice on a starved machine
IDLE = """\
#!/bin/sh
[ "$1" = info ] && exit 5
trap 'exit 75' USR1
while :; do sleep 1; done
"""
STUDY = """\
study: 1
deck: gear.yaml
list:
  - {parameters.speed: 30, time.end: 0.5}
  - {parameters.speed: 40, time.end: -1}
  - {parameters.speed: 50, time.end: 0.5}
  - {parameters.speed: 60, time.end: 30, time.adaptive: null}
outputs:
  load: {of: wheel.radial_force, take: max}
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with decks in it, the current one, while Slurm runs; `mecano` is on its path."""
    folder = tmp_path_factory.mktemp("jobs")
    gear = (INPUTS / "nose_gear_rigid.yaml").read_text()
    (folder / "gear.yaml").write_text(gear.replace("end: 4.0", "end: 0.5"))
    for old, new in LONG.items():
        gear = gear.replace(old, new)
    (folder / "long.yaml").write_text(gear)
    (folder / "study.yaml").write_text(STUDY)
    for name, text in SCRIPTS.items():
        (folder / f"{name}.sbatch").write_text(text)
    program = folder / "bin" / "mecano"
    program.parent.mkdir()
    program.write_text(f'#!/bin/sh\nexec {sys.executable} -m mecano "$@"\n')
    program.chmod(program.stat().st_mode | stat.S_IXUSR)
    here = os.getcwd()
    state = tmp_path_factory.mktemp("slurm")
    with pytest.MonkeyPatch.context() as patch, slurm.running(state):
        patch.setenv("PATH", f"{program.parent}{os.pathsep}{os.environ['PATH']}")
        patch.setenv("PYTHONPATH", str(Path(mecano.__file__).parent.parent))
        os.chdir(folder)
        subprocess.run([*COMMAND, "warmup", "gear.yaml", "long.yaml"], check=True)  # as the page says
        yield folder
        os.chdir(here)


def submitted(name, *options):
    """The number of a job of one of the scripts."""
    ended = subprocess.run(["sbatch", "--parsable", *options, f"{name}.sbatch"], capture_output=True, text=True)
    assert ended.returncode == 0, ended.stderr
    return ended.stdout.strip()


def ended(number, seconds=3600.0):
    """Wait until a job and all its tasks have ended: their states, and the exit codes of the tasks."""
    end = time.monotonic() + seconds
    while True:
        own = {key: state for key, state in slurm.states().items() if key.partition("_")[0] == number}
        if all(state in ("COMPLETED", "FAILED", "CANCELLED", "TIMEOUT") for state in own.values()):
            return own
        assert time.monotonic() < end, own
        time.sleep(1.0)


def restarts(number):
    """How often a job was put back into the queue."""
    return int(re.search(r"Restarts=(\d+)", slurm.reported("scontrol", "show", "job", number))[1])


def test_the_page_has_three_scripts():
    assert set(SCRIPTS) == {"long", "speeds", "pictures"}


def signalled(number, path):
    """Signal a job as Slurm does before its end, as soon as its run has written rows to ``path``."""
    slurm.waited(lambda: written(path) > 10, 600.0)
    slurm.reported("scancel", "--batch", "--signal=USR1", number)


def written(path):
    """How many rows a results file has, 0 as long as there is none."""
    try:
        with mecano.open_results(path) as results:
            return len(results.time)
    except ResultsError:
        return 0


def test_a_long_run_goes_back_into_the_queue_until_it_is_complete(folder):
    number = submitted("long")
    signalled(number, "long.h5")
    assert set(ended(number).values()) == {"COMPLETED"}
    assert restarts(number) == 1
    with mecano.open_results("long.h5") as results:
        assert results.status == "complete" and results.time[-1] == 30.0
        assert any(text.startswith("resumed at") for text in results.resumptions)


def test_a_run_that_makes_no_step_in_its_time_is_not_requeued(folder, tmp_path, monkeypatch):
    """Slurm itself sends the signal, 10 to 40 s after the start, to a program that never gets anywhere."""
    program = tmp_path / "mecano"
    program.write_text(IDLE)
    program.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}{os.pathsep}{os.environ['PATH']}")
    number = submitted("long", "--time=1", "--signal=B:USR1@20", "--output=idle.log")
    assert set(ended(number).values()) == {"FAILED"} and restarts(number) == 0
    assert "ExitCode=2:0" in slurm.reported("scontrol", "show", "job", number)
    assert "no step was made in this allocation" in (folder / "idle.log").read_text()


def test_an_array_and_pictures_of_it(folder):
    number = submitted("speeds", *PATIENT)
    pictures = submitted("pictures", f"--dependency=afterok:{number}", *PATIENT)
    assert set(ended(number).values()) == {"COMPLETED"} and set(ended(pictures).values()) == {"COMPLETED"}
    assert len(list(folder.glob("speed_*.h5"))) == 5
    assert list((folder / "pictures").glob("*.png")) and (folder / "report.html").stat().st_size > 100_000


def test_a_study_with_a_failing_case_and_one_that_needs_more_time(folder):
    words = ["sweep", "study.yaml", "--executor", "slurm", "--wait"]
    before = set(slurm.states())
    with subprocess.Popen([*COMMAND, *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        slurm.waited(lambda: set(slurm.states()) - before, 600.0)
        number = min(set(slurm.states()) - before).partition("_")[0]
        signalled(f"{number}_4", "study_runs/0004.h5")
        out, err = process.communicate(timeout=3600.0)
    code = process.returncode
    assert code == 3 and "3 complete, 1 failed" in out, (out, err)
    table = read_study("study_runs/table.h5")
    assert table["case/status"].tolist() == ["complete", "failed", "complete", "complete"]
    assert table["case/exit_code"].tolist() == [0.0, 2.0, 0.0, 0.0]
    with mecano.open_results("study_runs/0004.h5") as results:
        assert any(text.startswith("resumed at") for text in results.resumptions)
    assert sorted(ended(number).values()).count("FAILED") == 1 and restarts(f"{number}_4") == 1
