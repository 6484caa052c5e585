"""Generic tests of a slip law of tyres or a term of a law: functions that raise AssertionError."""

from collections.abc import Sequence

import numpy as np
from scipy.integrate import quad

from mecano.analyses.differences import difference
from mecano.analyses.kind_samples import GRAVITY, seed_of
from mecano.element_interface import Context, record
from mecano.elements.wheels.rolling_contact import law_samples
from mecano.elements.wheels.slip_law import Slip, SlipForces, SlipLaw
from mecano.elements.wheels.tire_law import slip_law_of
from mecano.laws.law_table import LawTable, breakpoints, evaluate_curve, evaluate_force, potential
from mecano.laws.term import Term
from mecano.maths.vector import Vec3
from mecano.schema import Values

T, L, N = Vec3(1.0, 0.0, 0.0), Vec3(0.0, 1.0, 0.0), Vec3(0.0, 0.0, 1.0)
STEP, RANGE = 1e-4, 3.0  # of differences, of arguments


class Tyre:
    """A slip law with its record, on a level ground."""

    def __init__(self, law: SlipLaw, values: Values):
        """Prepare the record for the ``values`` of a tyre law."""
        assert law.prepare is not None and law.record is not None, "a SlipLaw declares both by its fields"
        table = LawTable()
        prepared = {"radius": values.get("radius", 0.3), **law.prepare(values, Context(table, GRAVITY))}
        self.p = np.zeros(1, record(radius=(), **law.record)).view(np.recarray)
        for name, value in prepared.items():
            self.p[name][0] = value
        self.law, self.laws = law, table.array()

    def forces(
        self,
        load: float,
        v: Sequence[float] | np.ndarray,
        u: Sequence[float] | np.ndarray = (20.0, 0.0),
        omega: Sequence[float] | np.ndarray = (0.0, 0.0, 0.0),
        lean: float = 0.0,
        spin: float | None = None,
    ) -> SlipForces:
        """Return the SlipForces of a wheel that slips with v (2,) and moves with u (2,) [m/s]."""
        spin = (u[0] - v[0]) / 0.3 if spin is None else spin
        v, u = Vec3(v[0], v[1], 0.0), Vec3(u[0], u[1], 0.0)
        k = Slip(load, 0.02, 1.0, v, v, u, Vec3(*omega), spin, lean, T, L, N, 0.0)
        return self.law.forces(self.p[0], self.laws, k)


def tyres(law: SlipLaw) -> list[Tyre]:
    """Return the Tyres of the samples of a SlipLaw."""
    found = (wheel["tire_law"] for wheel, _, _ in law_samples(np.random.default_rng(4), law))
    return [Tyre(slip_law_of(values), values) for values in found]


def check_stated_power(law: SlipLaw) -> None:
    """The power of force and moment is that stated by the slip law: -(F.v + M.omega) = lost - given, lost >= 0."""
    check_power_of_tyres(law, tyres(law))


def check_power_of_tyres(law: SlipLaw, trials: Sequence[Tyre]) -> None:
    """Check ``check_stated_power`` for given Tyres; a passive law gives only the power of its moment."""
    rng, worked = seed_of(law.name), 0
    for tyre in trials:
        for _ in range(200):
            v, u = rng.normal(size=2) * 10.0 ** rng.uniform(-3, 1), rng.normal(size=2) * [20.0, 3.0]
            omega, load = rng.normal(size=3), rng.uniform(-10.0, 2e4)
            k = tyre.forces(load, v, u, omega, 0.1 * rng.normal())
            of_force, of_moment = k.F[0] * v[0] + k.F[1] * v[1], np.dot(k.M, omega)
            size = 1e-9 + abs(of_force) + abs(of_moment) + abs(k.given)
            error = abs(of_force + of_moment + k.lost - k.given)
            assert error <= 1e-12 * size, f"{error:.3g} W of {size:.3g} W"
            assert k.lost >= 0.0, f"{k.lost:.3g} W are dissipated"
            if law.passive:
                assert abs(k.given - of_moment) <= 1e-12 * size, f"a passive law gives {k.given:.3g} W"
            worked += k.lost > 0.0
    assert worked > 50 * len(trials), "the force does almost no work in the samples"


def check_no_load(law: SlipLaw) -> None:
    """A tyre without load has no tangential force and no moment."""
    for tyre in tyres(law):
        k = tyre.forces(0.0, (1.0, 2.0), omega=(0.1, 20.0, 0.3))
        most = np.abs([*k.F, *k.M]).max()
        assert most < 1e-6, f"without load it exerts {most:.3g} N or N m"


def _trials(term):
    """Yield (table, start, arguments away from its corners, corners) for each sample of a Term."""
    assert term.sample is not None, "it has no sample"
    rng = seed_of(term.name)
    for values in term.sample():
        law, table = ((term.name, values),), LawTable()
        start, corners = table.add(law), [*breakpoints(law), *(corner for corner, _ in term.stops(values))]
        found = [s for s in rng.uniform(-RANGE, RANGE, 40) if all(abs(s - c) > 5.0 * STEP for c in corners)]
        yield table.array(), start, found, sorted(corners)


def _close(found, expected, what):
    assert abs(found - expected) <= 1e-7 * (1.0 + abs(expected)), f"{what}: {found:.9g} instead of {expected:.9g}"


def check_derivatives(term: Term) -> None:
    """The derivatives of the term are those of its value."""
    rates = seed_of(term.name + " rates")
    for laws, start, arguments, _ in _trials(term):
        for s, v in zip(arguments, rates.uniform(-RANGE, RANGE, len(arguments)), strict=True):
            if term.role == "curve":
                _, d, h = evaluate_curve(laws, start, s)
                slopes = difference(lambda h: np.array(evaluate_curve(laws, start, s + h)), STEP)  # noqa: B023
                _close(d, slopes[0], "dy/ds")
                _close(h, slopes[1], "d2y/ds2")
            else:
                _, by_s, by_v = evaluate_force(laws, start, s, v)
                _close(by_s, difference(lambda h: evaluate_force(laws, start, s + h, v)[0], STEP), "dF/ds")  # noqa: B023
                _close(by_v, difference(lambda h: evaluate_force(laws, start, s, v + h)[0], STEP), "dF/dv")  # noqa: B023


def check_potential(term: Term) -> None:
    """The integral of the term is that of its value, at rest."""
    for laws, start, _, corners in _trials(term):
        edges = np.array([-RANGE, *(c for c in corners if -RANGE < c < RANGE), RANGE])
        for low, high in zip(edges[:-1], edges[1:], strict=True):
            area, _ = quad(lambda x: evaluate_force(laws, start, x, 0.0)[0], low, high, epsabs=1e-10, limit=200)  # noqa: B023
            _close(potential(laws, start, high) - potential(laws, start, low), area, "integral")


OF_SLIP_LAWS = check_stated_power, check_no_load
OF_TERMS = check_derivatives, check_potential
