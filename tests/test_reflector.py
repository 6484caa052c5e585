"""inputs/reflector.yaml: deployed at the time of the paper, symmetric, with every latch locked; and its writer."""

from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import numpy as np
import pytest
from time_runs import RecordedRun, input_deck

INPUTS = Path(__file__).parent.parent / "inputs"


def writer():
    """The module inputs/make_reflector.py."""
    spec = spec_from_file_location("make_reflector", INPUTS / "make_reflector.py")
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def deployment():
    return RecordedRun(input_deck("reflector"))


def locks(deployment):
    """Time of locking of each hinge [s]."""
    return {h.element.split("'")[1]: h.t for h in deployment.event_records if h.name == "locks"}


def test_the_deck_is_the_output_of_its_writer():
    module = writer()
    assert module.deck(module.options([])) == (INPUTS / "reflector.yaml").read_text()


@pytest.mark.parametrize("wrong", ["--modules -1", "--curvature 0", "--fold 90", "--height 0", "--batten -1"])
def test_what_no_reflector_can_have_is_refused(wrong, capsys):
    with pytest.raises(SystemExit) as stop:
        writer().options(wrong.split())
    assert stop.value.code == 2 and wrong.split()[0] in capsys.readouterr().err


@pytest.mark.parametrize("modules, longerons, faces", [(1, 7, 12), (2, 12, 23), (7, 31, 72), (19, 73, 186)])
def test_modules_share_longerons_and_faces(modules, longerons, faces):
    """Counted on the triangular lattice, and by Euler's formula."""
    module = writer()
    of = module.Reflector(module.options(["--modules", str(modules)]))
    assert (len(of.points), len(of.faces)) == (longerons, faces)
    assert len(of.points) - len(of.faces) + 6 * modules == 1  # vertices - edges + triangles of a disc
    assert sum(spoke for *_, spoke in of.faces) == 6 * modules


def test_all_latches_lock_at_the_time_of_the_paper(deployment):
    times = locks(deployment)
    assert len(times) == 24
    assert max(times.values()) == pytest.approx(3.65, abs=0.05)  # Cardona, Geradin & Doan 1991, section 4.1


def test_symmetric_hinges_lock_together(deployment):
    times = locks(deployment)
    for level in ("low", "high"):
        for spoke in (True, False):
            group = [t for name, t in times.items() if name.endswith(level) and name.startswith("face0_") == spoke]
            assert len(group) == 6 and np.ptp(group) < 1e-6


def test_curved_shape_is_reached(deployment):
    """The corners stand at 1 m and 1/(2 R) = 0.05 m above the middle; diagonals of 5e-4 strain press the battens."""
    for i in range(1, 7):
        for level, height in (("low", 0.0), ("high", 1.2)):
            x = deployment[f"nodes/post{i}_{level}/position"][-1]
            assert np.hypot(x[0], x[1]) == pytest.approx(1.0, abs=2e-3)
            assert x[2] - height == pytest.approx(0.05, abs=2e-3)


def test_energy_is_balanced_and_then_never_grows(deployment):
    """The integrator damps the oscillations of members after the shocks."""
    balance, times = deployment["energy/balance"], deployment.time
    first = min(h.t for h in deployment.event_records if h.impulse != 0.0)
    kinetic = deployment["energy/kinetic"].max()
    before = balance[(times > 0.1) & (times < first - 0.05)]
    assert np.ptp(before) < 0.01 * kinetic
    assert balance[times >= first].max() < before[-1] + 0.01 * kinetic


def test_steps(deployment):
    """400 of 10 ms, and one for each of at most 20 times at which events happen."""
    assert len(deployment.time) - 1 <= 420
