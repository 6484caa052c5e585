"""Nose gears in minimal coordinates: a planar model independent of mecano, for comparison."""

import math
from types import SimpleNamespace

import numpy as np
from scipy.integrate import solve_ivp


class PlanarGear:
    """The gear in its plane, points as complex numbers x + iz: load (X, Z), angle of the arm, spin of the wheel.

    The minimal coordinates of what a deck builds from bodies or beams and constraints: leg and brace move with the
    load, the arm turns about the elbow by theta (e^{-i theta} raises the wheel), the wheel about the axle.

    ``load`` [kg]: all that does not turn; ``arm``: mass [kg], centre of mass from the elbow [m] (complex), moment of
    inertia about the centre of mass [kg m2]. Wheel, laws and places are those of the deck.
    """

    def __init__(self, deck, load, arm):
        node = {name: d["position"][0] + 1j * d["position"][2] for name, d in deck.values["nodes"].items()}
        mount, lug = (node[name] for name in deck.values["elements"]["absorber"]["nodes"])
        rim = deck.values["elements"]["rim"]
        self.elbow = elbow = node["arm_elbow"]
        self.axle, self.lug, self.mount = node[rim["node"]] - elbow, lug - elbow, mount - elbow
        self.load, (self.arm, self.centre, self.J) = load, arm
        self.wheel, self.I = rim["mass"], rim["inertia"][1]
        self.oleo = {name: SimpleNamespace(**values) for name, values in deck.values["laws"]["oleo"]}
        self.tire = SimpleNamespace(**deck.values["tire_laws"]["nose_tire"])
        terms = dict(self.tire.radial)
        self.radial = np.polynomial.Polynomial(terms["polynomial"]["coefficients"])
        ((_, friction),) = self.tire.friction
        self.friction = SimpleNamespace(**friction)

    def absorber(self, s, v):
        """Force that pulls its ends together [N]."""
        gas, oil, dry, stop = (self.oleo[n] for n in ("gas_spring", "oil_damper", "dry_friction", "stop"))
        F = -gas.force * (gas.length / (gas.length + s)) ** gas.exponent
        F += (oil.compression if v < 0 else oil.rebound) * v * abs(v)
        u = min(abs(v) / dry.regularization, 1.0)
        F += dry.force * u * (2 - u) * math.copysign(1.0, v)
        return F + (stop.stiffness * (s - stop.upper) * max(0.0, 1 + stop.damping * v) if s > stop.upper else 0.0)

    def deformation(self, y):
        """Deformation of the tyre [m], positive or not, and extension of the absorber [m]."""
        turned = np.exp(-1j * y[2])
        height = y[1] + (self.elbow + self.axle * turned).imag
        return self.tire.radius - height, abs(self.mount - self.lug * turned) - abs(self.mount - self.lug)

    def contact(self, w, w1, u, spin):
        """Force of the ground, drag + i lift [N]."""
        if w <= 0:
            return 0j
        N = self.radial(w) * max(0.0, 1 + self.tire.radial_damping * w1)
        slip = u - spin * (self.tire.radius - w)
        f = self.friction
        mu = f.limit + (f.start - f.limit) * math.exp(-f.rate * abs(slip))
        p = min(abs(slip) / self.tire.slip_regularization, 1.0)
        return N * (1j - mu * p * (2 - p) * math.copysign(1.0, slip))

    def rates(self, t, y):
        """d/dt of (X, Z, theta, spin angle, and their rates); X, Z displacements of the load."""
        X1, Z1, theta1, spin = y[4:]
        turned = np.exp(-1j * y[2])
        a, c, lug = self.axle * turned, self.centre * turned, self.lug * turned
        w, s = self.deformation(y)
        d = self.mount - lug
        s_theta = -(d.conjugate() * -1j * lug).real / abs(d)
        hub = X1 + 1j * Z1 - 1j * a * theta1
        ground = self.contact(w, -hub.imag, hub.real, spin)
        total, first = self.load + self.arm + self.wheel, self.wheel * a + self.arm * c
        S = -1j * first  # momentum by theta'
        M = np.array([
            [total, 0, S.real],
            [0, total, S.imag],
            [S.real, S.imag, self.J + self.wheel * abs(a) ** 2 + self.arm * abs(c) ** 2],
        ])  # fmt: skip
        F = ground - 9.81j * total + first * theta1**2
        lever = (np.conj(-1j * a) * ground).real - 9.81 * S.imag - self.absorber(s, s_theta * theta1) * s_theta
        acceleration = np.linalg.solve(M, [F.real, F.imag, lever])
        return [*y[4:], *acceleration, -ground.real * (self.tire.radius - w) / self.I]

    def run(self, end, sink, speed):
        """Times at which the tyre meets or leaves the ground, states (n, 8)."""

        def gap(t, y):
            return self.deformation(y)[0]

        start = [0.0, 0.0, 0.0, 0.0, speed, sink, 0.0, 0.0]
        out = solve_ivp(self.rates, (0.0, end), start, "LSODA", events=gap, rtol=1e-9, atol=1e-10, max_step=2e-3)
        assert out.success
        return out.t_events[0], out.y.T
