r"""Momentum of a mechanism at the saved times of a run, with its mass and its centre of mass.

The forces of inertia of an element at rest are linear in the accelerations,

.. math::  f(a) = r(q, 0, a) - r(q, 0, 0) = M a,

so that they are the momentum for a = v. Summed over the nodes, with forces f_i and material moments m_i,

.. math::  p = \sum f_i(v), \qquad L = \sum (x_i - o) \times f_i(v) + R_i m_i(v)

In the same way, unit accelerations of all nodes give mass and centre of mass. Fixed nodes take part: the mass of a
member between a fixed and a free node moves.
"""

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from mecano.analyses.load_state import motions_in
from mecano.analyses.prepare import prepare
from mecano.analyses.resume import MOST, differences
from mecano.deck.deck import Deck
from mecano.errors import UsageError, name_list
from mecano.model.state import State
from mecano.model.system import System
from mecano.post.text_table import aligned
from mecano.results.opening import errors_as_damage
from mecano.results.provenance import to_json
from mecano.results.reader import open_results

WITH_MASSES = ("elements", "sections")  # of a deck


@dataclass(frozen=True, eq=False, repr=False)
class Momentum:
    """Momentum of a mechanism at the saved times of a run; vectors are inertial."""

    time: np.ndarray  # (n,) [s]
    mass: float  # [kg]
    center_of_mass: np.ndarray  # (n, 3) [m]
    linear: np.ndarray  # (n, 3) [N s]
    angular: np.ndarray  # (n, 3) [N m s], about the point ``about``
    about: tuple[float, float, float]  # [m], inertial

    @property
    def angular_about_center(self) -> np.ndarray:
        """Angular momentum about the centre of mass (n, 3) [N m s]."""
        return self.angular - np.cross(self.center_of_mass - self.about, self.linear)

    def __str__(self):
        return "\n".join(_lines(self))


def momentum(deck: Deck, results: str, about: Sequence[float] = (0.0, 0.0, 0.0)) -> Momentum:
    """Return the Momentum of a dynamic run of a checked deck; ``results`` is the path of its file.

    ``about`` [m] is the point to which the angular momentum refers. Raises the errors of ``mecano check``, ResultsError
    if the results do not belong to the deck or lack some of its unknowns, and UsageError for statics and if masses may
    differ from those of the run.
    """
    point = np.array(about)
    if point.shape != (3,) or point.dtype.kind not in "iuf" or not np.isfinite(point).all():
        raise UsageError(f"about={about!r}: write an inertial point, such as (0, 0, 1.5) [m]")
    prepared = prepare(deck)
    found = [(s.t, *_momentum(prepared.system, s, point.astype(float))) for s in motions_in(prepared, results)]
    _refuse_other_masses(deck, results)
    time, mass, center, linear, angular = (np.array(values) for values in zip(*found, strict=True))
    x, y, z = map(float, point)
    return Momentum(time, float(mass[0]), center, linear, angular, (x, y, z))


def _refuse_other_masses(deck, path):
    """Raise UsageError if the run was that of a deck with other elements or cross sections, whose masses may differ."""
    with errors_as_damage(path), open_results(path) as results:
        was, now = results.resolved, json.loads(to_json(deck.resolved()))
    found = [one for section in WITH_MASSES for one in differences(was.get(section), now.get(section), section)]
    if found:
        listed = name_list(found, MOST, "; ")
        raise UsageError(f"{path} is the run of another deck: it has {listed}; give the deck and the --set of the run")


def _momentum(system: System, s: State, o: np.ndarray) -> tuple[float, np.ndarray, np.ndarray, np.ndarray]:
    """Return mass [kg], centre of mass (3,), linear momentum (3,) and angular momentum (3,) about ``o`` of a state."""
    still = replace(s, z=s.z.copy(), v=np.zeros_like(s.v), a=np.zeros_like(s.a))
    still.z[system.n_q : system.n] = 0.0  # no reactions
    of_nodes = slice(6 * len(system.nodes))  # of the forces; those on scalars and signals follow
    at_rest = system.forces(still)[of_nodes]

    def resultant(a):
        return _resultant(system, s, system.forces(replace(still, a=a))[of_nodes] - at_rest, o)

    p, L = resultant(s.v)
    (along_x, about_x), (along_y, about_y) = (resultant(_unit(system, axis)) for axis in (0, 1))
    mass = 0.5 * (along_x[0] + along_y[1])
    moment = np.array([about_y[2], -about_x[2], about_x[1]])  # mass (center - o), from (center - o) x mass e
    return mass, o + moment / mass if mass > 0.0 else o, p, L


def _unit(system, axis):
    """Return the accelerations (n_all,) of all nodes by 1 m/s2 along an axis."""
    a = np.zeros(system.numbering.n_all)
    a[system.numbering.x + axis] = 1.0
    return a


def _resultant(system, s, forces, o):
    """Return the force (3,), and the moment (3,) about ``o``, of the forces and moments (6 n_nodes,) on all nodes."""
    of = system.numbering
    f, m = np.hsplit(forces.reshape(-1, 6), 2)
    moments = np.cross(s.z[of.x[:, None] + np.arange(3)] - o, f) + np.einsum("nij,nj->ni", s.R[of.rotation], m)
    return f.sum(axis=0), moments.sum(axis=0)


def _vectors(found):
    """Return (name, unit, values (n, 3)) of the vectors of a Momentum."""
    return (
        ("center_of_mass", "m", found.center_of_mass),
        ("linear_momentum", "N s", found.linear),
        ("angular_momentum", "N m s", found.angular),
        ("angular_momentum_about_center", "N m s", found.angular_about_center),
    )


def _lines(found):
    """Return the lines of the table: each vector at the first and the last saved time, and its largest change."""
    first, last = (f"at {t:.6g} s" for t in found.time[[0, -1]])
    table: list[tuple[str, ...]] = [("", "", "x", "y", "z", "largest change")]
    for name, unit, values in _vectors(found):
        change = np.linalg.norm(values - values[0], axis=1).max()
        table.append((f"{name} [{unit}]", first, *(f"{x:.6g}" for x in values[0]), ""))
        table.append(("", last, *(f"{x:.6g}" for x in values[-1]), f"{change:.3g}"))
    place = ", ".join(f"{x:g}" for x in found.about)
    head = f"mass {found.mass:.6g} kg; {len(found.time)} saved times; angular momentum about ({place}) m"
    return [head, *aligned(table, "<<>>>>")]


def rows(found: Momentum) -> Iterator[list[str]]:
    """Yield the rows of a Momentum as texts in SI units, the first of them the heading."""
    yield ["time [s]", *(f"{name}.{axis} [{unit}]" for name, unit, _ in _vectors(found) for axis in "xyz")]
    for line in np.column_stack([found.time, *(values for *_, values in _vectors(found))]).tolist():
        yield [repr(x) for x in line]
