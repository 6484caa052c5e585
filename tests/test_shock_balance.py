"""Shocks of every kind at once, in random mechanisms: momentum, energy, complementarity. One model, few seconds.

A tree of bodies with a hinge, a prismatic and a cylindrical joint, each with a latch and stops, cables of every sort
between the bodies, and balls that meet a plane. Any set of their events may happen together.
"""

import json

import numpy as np
import pytest
from time_runs import deck

from mecano.analyses.prepare import integrator_of, prepare

SEEDS = range(6)
BODIES = 4


def mechanism(seed, grounded):
    """A checked deck: a random tree; grounded by a hinge and over planes, or free."""
    rng = np.random.default_rng(seed)
    at = rng.normal(size=(BODIES + 1, 3))
    nodes, elements, joints = {}, {}, {}
    for i in range(BODIES):
        for name, x in ((f"b{i}", at[i]), (f"c{i}", at[i + 1]), (f"d{i}", at[i] + rng.normal(size=3))):
            nodes[name] = {"position": x.tolist()}
        elements[f"body{i}"] = {
            "type": "rigid_body", "node": f"b{i}", "mass": rng.uniform(0.5, 3.0), "attached": [f"c{i}", f"d{i}"],
            "center_of_mass": rng.normal(size=3).tolist(), "inertia": [0.7, 0.8, 0.9],
        }  # fmt: skip
    for i, kind in enumerate(("hinge", "prismatic", "cylindrical")):
        ends = {"angle": 0.5} if kind == "hinge" else {"displacement": 0.5}
        joints[f"j{i}"] = {
            "type": kind, "nodes": [f"c{i}", f"b{i + 1}"], "axis": rng.normal(size=3).tolist(), "latch": ends,
            "stops": {"lower": -1.0, "upper": 1.0, "restitution": rng.uniform()},
        }  # fmt: skip
    for i, candidate in enumerate(("shock", "hold")):
        rope = {"type": "cable", "nodes": [f"d{i}", f"d{i + 2}"], "axial_stiffness": 100.0, "at_full_length": candidate}
        far = np.linalg.norm(np.subtract(nodes[f"d{i}"]["position"], nodes[f"d{i + 2}"]["position"]))
        elements[f"rope{i}"] = {**rope, "natural_length": 2.0 * far}
        elements[f"winder{i}"] = {**rope, "natural_length": 3.0 * far, "payout_tension": 1.0}
    grounds = {}
    if grounded:
        joints["root"] = {"type": "hinge", "nodes": ["ground", "b0"], "axis": rng.normal(size=3).tolist()}
        for i in range(BODIES):
            normal = rng.normal(size=3)
            point = np.array(nodes[f"d{i}"]["position"]) - normal
            grounds[f"g{i}"] = {"plane": {"point": point.tolist(), "normal": normal.tolist()}}
            elements[f"foot{i}"] = {
                "type": "plane_contact", "node": f"d{i}", "ground": f"g{i}", "restitution": rng.uniform(),
            }  # fmt: skip
    return deck(json.dumps({
        "mecano": 1, "nodes": nodes, "elements": elements, "joints": joints, "grounds": grounds,
        "gravity": [0.0, 0.0, 0.0], "time": {"end": 1.0, "step": 1e-3},
    }))  # fmt: skip


class Struck:
    """A mechanism in random motion, some of its contacts closed, and the shock of a random set of events."""

    def __init__(self, seed, grounded, share=0.5):
        rng = np.random.default_rng(100 + seed)
        prepared = prepare(mechanism(seed, grounded))
        integrator = integrator_of(prepared)
        self.system, self.shocks, method = prepared.system, integrator.shocks, integrator.method
        n_q = self.system.n_q
        s = prepared.state.copy()
        s.memory = self.system.commit(s)
        s.phases = s.phases.copy()
        for b in self.system.batches:
            if b.kind.name == "wound_cable":  # slack, taut or paying out
                s.phases[b.phases] = rng.integers(0, 3, len(b.p))
        s.phases[self.system.followers[:, 0]] = s.phases[self.system.followers[:, 1]]
        contacts = [c for c in self.shocks.impact_candidates if c.opened == c.before and c.through == c.after]
        closed = list({c.phase: c for c in contacts if rng.uniform() < 0.2}.values())
        s = self.shocks.impact_candidates.in_phase(s, closed, "after")
        s.v[:n_q] = rng.normal(size=n_q)
        self.before, _ = method.start(s, 1e-3)
        hit = np.zeros(len(self.system.event_values(s)), bool)
        for phase in {c.phase for c in self.shocks.impact_candidates}:
            ready = [
                c for c in self.shocks.impact_candidates if c.phase == phase and c.before == self.before.phases[phase]
            ]
            ready = [c for c in ready if seed % 2 or c.restitution > 0.0]  # in half of them all may rebound
            if ready and rng.uniform() < share:
                hit[rng.choice(ready).event] = True
        self.shock = self.shocks.solve_impact(self.before, hit)
        self.after = self.shock.state

    def kinetic(self, s):
        return float(self.system.observe(s).energy[0])

    def momenta(self, s):
        """Linear and angular momentum (6,) about the origin, inertial, and the sum of their sizes."""
        of, total, size = self.system.numbering, np.zeros(6), 0.0
        (bodies,) = (b for b in self.system.batches if b.kind.name == "rigid_body")
        names = [node.name for node in self.system.nodes]
        for p, owner in zip(bodies.p, bodies.names, strict=True):
            i = names.index("b" + owner.split("'")[1][4:])
            x, v, omega, R = s.z[of.x[i]:][:3], s.v[of.x[i]:][:3], s.v[of.r[i]:][:3], s.R[of.rotation[i]]  # fmt: skip
            arm = R @ p["c"]
            momentum = p["mass"] * (v + np.cross(R @ omega, arm))
            spin = R @ p["J_C"] @ omega
            total += np.concatenate([momentum, np.cross(x + arm, momentum) + spin])
            size += np.abs(momentum).sum() + np.abs(spin).sum()
        return total, size

    def unbalanced(self):
        """M dv - B^T Lambda of all unknowns (n_all,): zero for the free ones, impulses of the ground for the others."""
        n_q, n, s = self.system.n_q, self.system.n, self.before.copy()
        s.v[:], s.a[:], s.z[n_q:n] = 0.0, 0.0, 0.0
        found = []
        for dv, impulses in ((0.0, 0.0), (self.after.v - self.before.v, self.shock.impulses)):
            s.phases = self.shock_phases()
            s.a[:], s.z[n_q:n] = dv, impulses
            found.append(self.system.assemble(s).residual)
        r = found[1] - found[0]
        r[n_q:n] = 0.0
        return r

    def shock_phases(self):
        """Modes in which everything that had an impulse holds."""
        pushed = [c for c in self.shocks.impact_candidates if self.shock.impulses[c.lead] != 0.0]
        here = [c for c in pushed if c.before == self.before.phases[c.phase] or c.after == self.before.phases[c.phase]]
        named = {(h.element, h.name) for h in self.shock.event_records}
        met = [c for c in here if (c.element, c.closing.name) in named or c.after == self.before.phases[c.phase]]
        return self.shocks.impact_candidates.in_phase(self.before, met, "through").phases


@pytest.fixture(scope="module")
def struck():
    return {(seed, grounded): Struck(seed, grounded) for seed in SEEDS for grounded in (False, True)}


cases = pytest.mark.parametrize("case", [(s, g) for s in SEEDS for g in (False, True)], ids=str)


@cases
def test_momentum_is_conserved_but_for_the_impulses_of_the_ground(case, struck):
    one = struck[case]
    of, r = one.system.numbering, one.unbalanced()
    (before, size), (after, _) = one.momenta(one.before), one.momenta(one.after)
    assert np.abs(r[: of.n_q]).max() <= 1e-12 * size
    given = np.zeros(6)
    for place in {int(i) for i in of.x if i >= of.n}:
        x = one.before.z[place : place + 3]
        given += np.concatenate([r[place : place + 3], np.cross(x, r[place : place + 3])])
    for place, rotation in {int(i): int(k) for i, k in zip(of.r, of.rotation, strict=True) if i >= of.n}.items():
        given[3:] += one.before.R[rotation] @ r[place : place + 3]
    for b in one.system.batches:
        if b.kind.name == "plane_contact":
            for p, dofs, rows in zip(b.p, b.dofs, b.multipliers, strict=True):
                push = p["normal"] * one.shock.impulses[rows[0]]
                given += np.concatenate([push, np.cross(one.before.z[dofs[:3]], push)])
    idle = np.abs(one.shock.impulses).max() <= 1e-12 * size  # rounding opens a contact, or not
    assert one.shock.event_records or idle
    assert (not case[1]) <= (not given.any())
    np.testing.assert_allclose(after - before, given, atol=1e-12 * size, rtol=0.0)


@cases
def test_energy_lost_equals_the_change_of_energy_and_is_not_negative(case, struck):
    one = struck[case]
    before, after = one.kinetic(one.before), one.kinetic(one.after)
    assert one.shock.given == pytest.approx(0.0, abs=1e-12 * before)
    assert before - after == pytest.approx(one.shock.lost, abs=1e-12 * before)
    assert sum(h.lost for h in one.shock.event_records) == pytest.approx(one.shock.lost, abs=1e-12 * before)
    assert one.shock.lost >= -1e-12 * before


@cases
def test_constraints_hold_and_contacts_neither_pull_nor_enter(case, struck):
    one = struck[case]
    size = np.abs(one.before.v).max()
    rates = one.system.constraint_derivatives(one.after)[:, 1]  # of what holds after the shock
    assert np.abs(rates).max() <= 1e-11 * size
    contacts = [c for c in one.shocks.impact_candidates if c.restitution >= 0.0]
    assert min(one.shock.impulses[c.lead] for c in contacts) >= 0.0
    for c in contacts:
        if (c.element, c.closing.name) in {(h.element, h.name) for h in one.shock.event_records}:
            rates = [
                one.system.constraint_derivatives(one.shocks.impact_candidates.in_phase(s, [c], "through"))[c.lead, 1]
                for s in (one.before, one.after)
            ]
            assert rates[0] <= 1e-11 * size and rates[1] >= -1e-11 * size


def test_the_samples_reach_their_events(struck):
    """Several at once, of every kind, some that rebound, some that stay, some contacts that were closed and opened."""
    event_records = [one.shock.event_records for one in struck.values()]
    names = {h.name for of in event_records for h in of}
    assert {"locks", "meets lower stop", "meets upper stop", "becomes taut at full length", "touches"} <= names
    assert any(name.startswith("leaves") or name in ("lifts off", "goes slack") for name in names)
    assert max(map(len, event_records)) >= 4
    met = [h for of in event_records for h in of if h.unit]
    assert {h.before == h.after for h in met} == {True, False}
