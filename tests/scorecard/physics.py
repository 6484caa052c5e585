"""Line 12: the cases of the verification manual, each within its tolerance."""

import subprocess
import sys
import tempfile
import xml.etree.ElementTree as tree
from pathlib import Path

from scorecard.trial import Job, Line, Trial

LINES = (Line(12, "the cases of the verification manual within their tolerances", 8, 0),)  # as many as there are
TESTS = Path(__file__).resolve().parents[1]
WALL = 3000.0  # s
FEW = ("test_closed_forms.py", "test_springs.py")  # of a quick scorecard


def jobs(lines, factor, seed):
    """One job for each file of tests that has such cases."""
    for path in sorted(TESTS.glob("test_*.py")):
        if "verify(" in path.read_text() and (factor >= 1 or path.name in FEW):
            yield Job(12, path.name, lambda folder, path=path: cases(path, folder), wall=WALL)


def cases(path, folder):
    """The Trials of a file: each test that checks for the manual."""
    report = folder / "report.xml"
    words = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", path]
    words += ["--verification", folder / "manual.json", f"--junitxml={report}"]
    with tempfile.TemporaryFile() as out:
        subprocess.run(list(map(str, words)), cwd=TESTS.parent, stdout=out, stderr=out)
    return outcomes(report.read_text()) if report.exists() else f"{path.name} could not be run"


def outcomes(text):
    """Trials of a report of pytest (JUnit)."""
    found = []
    for case in tree.fromstring(text).iter("testcase"):
        wrong = [child for child in case if child.tag in ("failure", "error")]
        if any(child.tag == "skipped" for child in case):
            continue
        why = (wrong[0].get("message") or "failed").splitlines()[0] if wrong else ""
        found.append(Trial(12, f"{case.get('classname')}::{case.get('name')}", why))
    return found
