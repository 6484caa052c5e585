"""One thread for the linear algebra of each process, as in the command line, because tests run in parallel.

Also the fixture by which tests report their results to the verification manual.
"""

import gc
import hashlib
import os
from pathlib import Path

for _variable in ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(_variable, "1")

import mecano  # noqa: E402
from mecano.jit import ahead  # noqa: E402
from mecano.jit.store import folder  # noqa: E402

gc.set_threshold(50_000)  # as many objects are made between two collections, which take their time
ahead.cores = lambda: 1  # the tests run in parallel, and a process that compiles all compiles shared functions once

SOURCES = sorted(Path(mecano.__file__).parent.rglob("*.py"))
KEY = hashlib.sha256(b"".join(path.read_bytes() for path in SOURCES)).hexdigest()[:16]
os.environ["NUMBA_CACHE_DIR"] = str(folder() / f"tests-{KEY}")  # of functions that only tests call, see instances.py

import pytest  # noqa: E402


def pytest_addoption(parser):
    parser.addoption("--verification", metavar="FILE", help="run the tests of the verification manual, and write it")


@pytest.hookimpl(optionalhook=True)  # of pytest-xdist
def pytest_xdist_auto_num_workers():
    """Run one more process than there are cores for ``-n auto``: many tests wait for commands that they start."""
    return (os.cpu_count() or 1) + 1


def pytest_configure(config):
    path = config.getoption("--verification")
    if path:
        from verification import Manual

        config.pluginmanager.register(Manual(path))


def pytest_collection_finish():
    gc.freeze()  # thousands of tests stay in memory, and each collection would visit them


@pytest.fixture
def verify(request):
    """Check of a number against its reference: see verification.py."""
    from verification import Verify

    return Verify(request.node.user_properties)
