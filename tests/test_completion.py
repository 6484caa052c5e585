"""`mecano completion`: completions offered by a shell."""

import os
import shutil
import subprocess
import sys

import pytest
from click.testing import CliRunner

from mecano.cli import commands

SOURCED = """
source <(mecano completion bash)
[[ $(complete -p mecano) == *"-F _mecano_completion mecano" ]]
COMP_WORDS=({words}) COMP_CWORD={place}
compopt() {{ echo "files"; }}
_mecano_completion mecano
printf '%s\\n' "${{COMPREPLY[@]:-}}"
"""


@pytest.mark.skipif(not shutil.which("bash"), reason="bash is not installed")
@pytest.mark.parametrize(
    "words, expected",
    [
        (("mecano", "exam"), ["example"]),
        (("mecano", "example", "nose_gear_"), ["nose_gear_drop", "nose_gear_rigid"]),
        (("mecano", "new", "pend"), ["pendulum"]),
        (("mecano", "explain", "prescribed_"), ["prescribed_angle", "prescribed_length", "prescribed_position"]),
        (("mecano", "run", "--max"), ["--max-walltime"]),
        (("mecano", "completion", ""), ["bash", "zsh", "fish"]),
        (("mecano", "run", "deck"), ["files"]),
    ],
)
def test_bash_completes(words, expected, tmp_path):
    program = tmp_path / "mecano"
    program.write_text(f'#!/bin/sh\nexec {sys.executable} -m mecano "$@"\n')
    program.chmod(0o755)
    quoted = " ".join(f"'{word}'" for word in words)
    script = SOURCED.format(words=quoted, place=len(words) - 1)
    path = f"{tmp_path}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(["bash", "-euc", script], capture_output=True, text=True, env={**os.environ, "PATH": path})
    assert done.stdout.split() == expected, done.stderr


@pytest.mark.parametrize("shell, begins", [("zsh", "#compdef mecano"), ("fish", "function _mecano_completion")])
def test_other_shells_have_a_script(shell, begins):
    assert CliRunner().invoke(commands, ["completion", shell]).output.startswith(begins)
