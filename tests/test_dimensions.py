"""Results do not depend on the units: a deck scaled in length, mass and time gives the scaled motion.

The scales are powers of two, which round no number; gravity is the same in a model of a thousandth of the size.
"""

import numpy as np
import pytest
from equilibria import Path
from scaled_decks import Units
from small_motions import eigenvalues
from test_invariance import largest_by_unit
from time_runs import INPUTS, RecordedRun, input_deck

from mecano.deck.units import dimension_of

SMALL = Units(2.0**-10, 2.0**-30, 2.0**-5)
LARGE = Units(2.0**10, 2.0**30, 2.0**5)
SLOW = Units(1.0, 1.0, 2.0**10)  # with a gravity of 1e-5 m/s2
TIGHT = ("time.newton.force_tolerance=1e-12", "time.newton.constraint_tolerance=1e-14")
SHARED = 1e-5  # of the acting forces: what rounding changes in the reactions of redundant constraints (theory.md)
MOTIONS = {
    "axle_on_slope": 1e-9, "ball_in_pipe": 1e-9, "beam_spin_up": 1e-9, "bricard": SHARED, "cable_snatch": 1e-9,
    "cam": 1e-9, "flyball_governor": 1e-9, "thruster": 1e-9,
}  # fmt: skip

EXTREMES = {
    "long": Units(2.0**14, 1.0, 1.0), "short": Units(2.0**-14, 1.0, 1.0), "heavy": Units(1.0, 2.0**20, 1.0),
    "light": Units(1.0, 2.0**-20, 1.0), "slow": Units(1.0, 1.0, 2.0**10), "fast": Units(1.0, 1.0, 2.0**-10),
}  # fmt: skip
UNDECLARED = {  # what has no unit in the deck
    "superelement_arm": "matrices", "elliptical_gears": "a function", "magic_formula_sweep": "coefficients",
    "trailing_wheel_bump": "a random road",
}  # fmt: skip
FLOOR = 1e-3  # of the quantity made of length scale, duration and largest force: smaller ones may be rounding


@pytest.mark.parametrize("units", [SMALL, LARGE, SLOW], ids=["small", "large", "slow"])
@pytest.mark.parametrize("name", MOTIONS)
def test_motion_and_reactions(name, units):
    """All outputs of twenty steps, relative to the largest of their unit."""
    deck = input_deck(name, *TIGHT)
    deck.values["time"] |= {"end": 20 * deck.values["time"]["step"], "adaptive": None}
    here, there = RecordedRun(deck), RecordedRun(units.scaled(deck))
    sizes = largest_by_unit(here)
    sizes["N m"] = max(sizes.get("N m", 0.0), sizes.get("N", 0.0) * here.prepared.length)
    for path, column in here.columns.items():
        found = there[path] / units.of(column.unit)
        np.testing.assert_allclose(found, here[path], rtol=0, atol=MOTIONS[name] * sizes[column.unit], err_msg=path)


def largest_of(recorded):
    """Return the largest value of the run for each unit, at least FLOOR."""
    sizes, duration, length = largest_by_unit(recorded), recorded.time[-1] - recorded.time[0], recorded.prepared.length
    force = max(sizes.get("N", 0.0), sizes.get("N m", 0.0) / length, 1e-200)
    for unit, powers in {unit: dimension_of(unit) for unit in sizes}.items():
        if powers is not None:
            natural = np.prod(np.power([length, force * duration**2 / length, duration], powers))
            sizes[unit] = max(sizes[unit], FLOOR * natural)
    return sizes


@pytest.mark.slow
@pytest.mark.parametrize("extreme", EXTREMES)
@pytest.mark.parametrize("name", sorted(path.stem for path in INPUTS.glob("*.yaml") if path.stem not in UNDECLARED))
def test_sixty_steps_of_the_examples(name, extreme):
    """All outputs to 1e-6 of the largest of their unit; tyres have regularized speeds in m/s."""
    deck, units = input_deck(name), EXTREMES[extreme]
    if not deck.values["time"] or deck.values["signals"]:
        pytest.skip("not integrated, or with signals, whose formulas have units of their own")
    deck = input_deck(name, *TIGHT)
    deck.values["time"] |= {"end": deck.values["time"]["start"] + 60 * deck.values["time"]["step"], "adaptive": None}
    on_tyres = any("tire_law" in d for d in deck.values["elements"].values())
    here = RecordedRun(deck)
    if on_tyres and units.sizes[1] == 1.0 or any(path.startswith("formulas/") for path in here.columns):
        pytest.skip("speeds in m/s, or a formula with units of its own")
    there, sizes = RecordedRun(units.scaled(deck)), largest_of(here)
    for path, column in here.columns.items():
        found, wanted = there[path] / units.of(column.unit), here[path]
        if path.endswith("/rotation"):  # of which q and -q are the same
            found = found * np.sign(np.sum(found * wanted, axis=-1, keepdims=True))
        np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-6 * sizes[column.unit], err_msg=path)


@pytest.mark.parametrize("name", ["lateral_buckling", "snap_through"])
def test_equilibrium_paths(name):
    """Load factors and unstable directions of all points."""
    deck = input_deck(name)
    here, there = Path(deck), Path(SMALL.scaled(deck))
    np.testing.assert_allclose(there.factors, here.factors, rtol=1e-9)
    np.testing.assert_array_equal(there.unstable, here.unstable)


@pytest.mark.parametrize("name", ["caster_shimmy", "heavy_top"])
def test_small_motions(name):
    """Eigenvalues about steady running and about a spin."""
    deck = input_deck(name)
    here, there = eigenvalues(deck, np.inf), eigenvalues(SMALL.scaled(deck), np.inf) * SMALL.of("s")
    np.testing.assert_allclose(there, here, rtol=1e-8, atol=1e-8 * np.abs(here).max())


def test_small_motions_of_a_small_caster():
    """A wheel of 10 mm at 50 mm/s rolls forward as one of 0.32 m at 1.6 m/s does."""
    deck = input_deck("caster_shimmy", "parameters.speed=1.6")
    here, there = eigenvalues(deck, np.inf), eigenvalues(Units(2.0**-5, 1.0, 1.0).scaled(deck), np.inf)
    np.testing.assert_allclose(there, here, rtol=1e-8, atol=1e-8 * np.abs(here).max())


def test_slip_of_a_small_wheel():
    """A wheel of 9.4 mm at 0.31 m/s: slip angle and lateral force are those of one of 0.3 m, scaled."""
    deck, units = input_deck("step_slip"), Units(2.0**-5, 1.0, 1.0)
    here, there = RecordedRun(deck), RecordedRun(units.scaled(deck))
    for output, shares in (("slip_angle", 2e-3), ("lateral_force", 5e-3)):
        column = here[f"elements/tire/{output}"]
        found = there[f"elements/tire/{output}"] / units.of(here.columns[f"elements/tire/{output}"].unit)
        np.testing.assert_allclose(found[10:], column[10:], rtol=0, atol=shares * np.abs(column).max())
