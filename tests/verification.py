"""Numbers of the tests for the verification manual: each is checked, as in any test, and reported with its reference.

A test that asks for the fixture ``verify`` checks with it instead of with an assert of its own:

    verify("Mechanisms", "pendulum: period [s]", found, 2.367841947576237, "elliptic integral", relative=1e-8)

``pytest --verification FILE`` runs these tests alone and writes their reports; docs/site/verification.py shows it.
"""

import json
from pathlib import Path

import numpy as np
import pytest
from convergence import check_second_order

PROPERTY = "verified"


class Verify:
    """Checks of one test; ``reported`` are pairs (PROPERTY, record), which pytest keeps with the report of the test."""

    def __init__(self, reported):
        self.reported = reported

    def __call__(self, subject, what, found, reference, source, *, relative=None, absolute=None, remark=""):
        """``found`` is within the tolerance of ``reference``, numbers or arrays (n, ...); exactly one tolerance."""
        assert (relative is None) != (absolute is None), "one tolerance"
        found, reference = np.broadcast_arrays(np.asarray(found), np.asarray(reference))
        errors = np.abs(found - reference) / (1.0 if relative is None else np.abs(reference))
        worst = int(np.argmax(errors))
        record = {
            "subject": subject, "what": what, "source": source, "count": found.size, "remark": remark,
            "found": text(found.flat[worst]), "reference": text(reference.flat[worst]),
            "error": float(errors.flat[worst]), "tolerance": float(absolute if relative is None else relative),
            "measure": "absolute" if relative is None else "relative",
        }  # fmt: skip
        self.reported.append((PROPERTY, record))
        assert record["error"] <= record["tolerance"], record

    def second_order(self, subject, what, coarse, fine, reference, extrapolated, source):
        """Do as ``check_second_order``, and report the value extrapolated from both steps, and the order."""
        check_second_order(coarse, fine, reference, extrapolated)
        before, after = (np.abs(np.asarray(values) - reference).max() for values in (coarse, fine))
        self(
            subject, what, (4.0 * np.asarray(fine) - coarse) / 3.0, reference, source, absolute=extrapolated,
            remark=f"order {np.log2(before / after):.2f}",
        )  # fmt: skip


def text(value):
    """A number, as the manual shows it."""
    value = complex(value)
    return f"{value.real:.10g}" + (f" {value.imag:+.10g} i" if value.imag else "")


class Manual:
    """A plugin of pytest that collects the reports of tests from all processes, and writes them at the end."""

    def __init__(self, path):
        self.path, self.records = Path(path), []

    @pytest.hookimpl
    def pytest_collection_modifyitems(self, config, items):
        """Deselect tests that report nothing."""
        config.hook.pytest_deselected(items=[item for item in items if "verify" not in item.fixturenames])
        items[:] = [item for item in items if "verify" in item.fixturenames]

    @pytest.hookimpl
    def pytest_runtest_logreport(self, report):
        """Collect the reports of a test."""
        if report.when == "call":
            self.records += [record for name, record in report.user_properties if name == PROPERTY]

    @pytest.hookimpl
    def pytest_sessionfinish(self, session):
        """Write the file; the processes of pytest-xdist leave it to the one that started them."""
        if not hasattr(session.config, "workerinput"):
            self.path.parent.mkdir(parents=True, exist_ok=True)
            self.records.sort(key=lambda record: (record["subject"], record["what"]))
            self.path.write_text(json.dumps(self.records, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
