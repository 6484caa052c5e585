"""A study as a Slurm job array: a script in the folder of the study, with one task for each case."""

import os
import shlex
import shutil
import subprocess
from collections.abc import Sequence
from typing import TYPE_CHECKING

from mecano.errors import ResultsError, UsageError
from mecano.results.whole_file import make_folder
from mecano.study.case_processes import PROGRAM
from mecano.study.pool import Limits, case_words

if TYPE_CHECKING:
    from mecano.study.execution import Due
    from mecano.study.folder import Folder
    from mecano.study.read import Case

NOTICE = 60  # s before its end at which a task is signalled, unless the user's options set another time
SCRIPT = """\
#!/bin/bash
#SBATCH --job-name={name}
#SBATCH --array={numbers}
#SBATCH --ntasks=1
#SBATCH --cpus-per-task=1
#SBATCH --requeue
#SBATCH --signal=B:USR1@{notice}
#SBATCH --open-mode=append
#SBATCH --output={output}
trap 'asked=yes; [ -n "$run" ] && kill -USR1 $run' USR1
cd {directory} || exit 5
steps() {{ {info} "$(printf {results} "$SLURM_ARRAY_TASK_ID")" 2>/dev/null | grep '^  run '; }}
before=$(steps)
{command} "$SLURM_ARRAY_TASK_ID" &
run=$!
[ -n "$asked" ] && kill -USR1 $run # the signal came before the case had begun
wait $run; code=$?
while kill -0 $run 2>/dev/null; do wait $run; code=$?; done # the signal ended the first wait
case $code in 75 | 138 | 152) # stopped in time, while it began, or by its limit of processor time: into the queue again
    if [ "$(steps)" = "$before" ]; then
        echo "mecano: no step was made in this allocation; the task is not requeued: give it more --time" >&2
        exit 2
    fi
    for attempt in 1 2 3 4 5; do # a busy controller may refuse
        scontrol requeue "${{SLURM_ARRAY_JOB_ID}}_${{SLURM_ARRAY_TASK_ID}}" && break
        sleep 5
    done ;;
esac
exit $code
"""


def script(folder: "Folder", cases: "Sequence[Case]", limits: Limits) -> str:
    """Return the text of the script that runs these cases, one in each task."""
    command = shlex.join([*PROGRAM, *case_words(folder, limits)])
    output = f"{folder.path.absolute()}/".replace("%", "%%") + "%4a.slurm"
    return SCRIPT.format(
        name=shlex.quote(folder.path.name), numbers=ranges([case.number for case in cases]), notice=NOTICE,
        output=shlex.quote(output), directory=shlex.quote(os.getcwd()), command=command,
        info=shlex.join([*PROGRAM, "info"]), results=shlex.quote(folder.pattern(".h5")),
    )  # fmt: skip


def ranges(numbers: Sequence[int]) -> str:
    """Return ascending whole numbers in the notation of Slurm arrays: 1-3,7."""
    parts, first = [], None
    for number, following in zip(numbers, [*numbers[1:], None], strict=True):
        first = number if first is None else first
        if following != number + 1:
            parts.append(str(first) if first == number else f"{first}-{number}")
            first = None
    return ",".join(parts)


def require() -> None:
    """Raise UsageError if there is no sbatch on this machine."""
    if not shutil.which("sbatch"):
        raise UsageError("there is no sbatch on this machine: run the study where Slurm's commands are installed")


def submit(folder: "Folder", due: "Due", limits: Limits, options: Sequence[str], wait: bool = False) -> str:
    """Submit the cases that are ``due`` (execution.py) to sbatch with ``options``; return the output of sbatch.

    The script is written into the folder. With ``wait``, return after all tasks have ended. Existing files of cases
    that start again are deleted when sbatch has accepted them. Raises ResultsError if sbatch refuses, UsageError
    without sbatch.
    """
    require()
    with folder.set_aside(due.again):
        return _submitted(folder, due.cases, limits, options, wait)


def _submitted(folder, cases, limits, options, wait):
    path = folder.path / "array.sbatch"
    make_folder(folder.path)
    try:
        path.write_text(script(folder, cases, limits), encoding="utf-8")
    except OSError as error:
        raise ResultsError(f"cannot write {path}: {error.strerror}") from error
    words = ["sbatch", *(["--wait"] if wait else []), *options, str(path)]
    ended = subprocess.run(words, capture_output=True, text=True)
    reported = ended.stdout.strip()
    if "Submitted" not in reported:
        raise ResultsError(f"sbatch refuses {path}: {ended.stderr.strip()}")
    return reported
