"""Equations of motion of a tree of rigid bodies in minimal coordinates: a reference that shares nothing with mecano.

A joint is a chain of turns and slides with one coordinate each, along axes carried by the parts before; motions and
reactions follow from the equations of Newton and Euler with the partial velocities of Kane. Vectors are inertial.
"""

from dataclasses import dataclass, field, replace

import numpy as np
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

G = np.array([0.0, 0.0, -9.81])


@dataclass
class Body:
    """A body whose joint to its ``parent`` (-1: the ground) is at the ``point`` at the start."""

    parent: int
    joint: str
    point: np.ndarray
    rotation: np.ndarray  # rotation vector of its axes at the start
    mass: float
    inertia: np.ndarray  # (3, 3) about the centre of mass, in its axes
    center: np.ndarray  # centre of mass from the point, in its axes
    axes: np.ndarray  # (3, 3): rows are the axes of the joint at the start
    rates: np.ndarray  # of the coordinates at the start
    pitch: float = 0.0

    @property
    def chain(self):
        """The turns and slides of its joint: (slide along, turn about, number of the coordinate of the joint)."""
        a, b, c, none = *self.axes, np.zeros(3)
        return {
            "hinge": [(none, a, 0)],
            "prismatic": [(a, none, 0)],
            "cylindrical": [(a, none, 0), (none, a, 1)],
            "screw": [(self.pitch / (2.0 * np.pi) * a, a, 0)],
            "planar": [(b, none, 0), (c, none, 1), (none, a, 2)],
            "universal": [(none, a, 0), (none, b, 1)],
            "spherical": [(none, a, 0), (none, b, 1), (none, c, 2)],
        }[self.joint]

    @property
    def coordinates(self):
        """The number of coordinates of its joint."""
        return self.chain[-1][2] + 1


@dataclass
class Spring:
    """A spring and damper between points of two bodies at the start; -1: the ground."""

    bodies: tuple
    points: np.ndarray  # (2, 3)
    length: float
    stiffness: float
    damping: float


@dataclass
class Frame:
    """Motion of a frame: point, rotation since the start, velocities, and accelerations for constant rates."""

    x: np.ndarray
    S: np.ndarray
    v: np.ndarray
    w: np.ndarray
    a: np.ndarray
    alpha: np.ndarray
    J_v: np.ndarray  # (3, n): partial velocities
    J_w: np.ndarray

    def at(self, r):
        """Return the frame at another point of the same body, r away."""
        turning = np.cross(self.w, np.cross(self.w, r))
        J_v = self.J_v - np.cross(r, self.J_w, axisb=0, axisc=0)
        return replace(
            self, x=self.x + r, v=self.v + np.cross(self.w, r), a=self.a + np.cross(self.alpha, r) + turning, J_v=J_v
        )

    def moved(self, slide, turn, q, rate, column):
        """Return the frame after a slide q ``slide`` and a turn by q about ``turn``, axes at the start."""
        along, about = self.S @ slide, self.S @ turn
        new = self.at(q * along)
        new.v, new.a = new.v + rate * along, new.a + 2.0 * rate * np.cross(self.w, along)
        new.w, new.alpha = self.w + rate * about, self.alpha + rate * np.cross(self.w, about)
        new.S = self.S @ Rotation.from_rotvec(q * turn).as_matrix()
        new.J_v, new.J_w = new.J_v.copy(), new.J_w.copy()
        new.J_v[:, column] += along
        new.J_w[:, column] += about
        return new


@dataclass
class Tree:
    """A tree of bodies; each has a parent before it in the list."""

    bodies: list
    springs: list = field(default_factory=list)

    def __post_init__(self):
        self.first = np.cumsum([0, *(body.coordinates for body in self.bodies)])

    def frames(self, y):
        """Return the Frame of each body at its point, for coordinates and rates y (2 n,)."""
        q, rates = np.split(y, 2)
        zero, none, found = np.zeros(3), np.zeros((3, len(q))), []
        for body, first in zip(self.bodies, self.first, strict=False):
            frame, origin = Frame(zero, np.eye(3), zero, zero, zero, zero, none, none), zero
            if body.parent >= 0:
                frame, origin = found[body.parent], self.bodies[body.parent].point
            frame = frame.at(frame.S @ (body.point - origin))
            for slide, turn, k in body.chain:
                frame = frame.moved(slide, turn, q[first + k], rates[first + k], first + k)
            found.append(frame)
        return found

    def center(self, i, frame):
        """Return the Frame of a body at its centre of mass, and its inertia (3, 3) in inertial axes."""
        body = self.bodies[i]
        R = frame.S @ Rotation.from_rotvec(body.rotation).as_matrix()
        return frame.at(R @ body.center), R @ body.inertia @ R.T

    def spring_forces(self, frames):
        """Yield (body, Frame at the point, force on it) of each end of a spring on a body."""
        for spring in self.springs:
            (x_a, v_a), (x_b, v_b) = (
                (point, np.zeros(3)) if i < 0 else self._motion(frames, i, point)
                for i, point in zip(spring.bodies, spring.points, strict=True)
            )
            length = np.linalg.norm(x_b - x_a)
            n = (x_b - x_a) / length
            force = spring.stiffness * (length - spring.length) + spring.damping * (n @ (v_b - v_a))
            for i, point, sign in zip(spring.bodies, spring.points, (1.0, -1.0), strict=True):
                if i >= 0:
                    frame = frames[i]
                    yield i, frame.at(frame.S @ (point - self.bodies[i].point)), sign * force * n

    def _motion(self, frames, i, point):
        at = frames[i].at(frames[i].S @ (point - self.bodies[i].point))
        return at.x, at.v

    def accelerations(self, y):
        """Return the second rates (n,) of the coordinates."""
        frames, n = self.frames(y), len(y) // 2
        M, f = np.zeros((n, n)), np.zeros(n)
        for i, body in enumerate(self.bodies):
            at, inertia = self.center(i, frames[i])
            M += body.mass * at.J_v.T @ at.J_v + at.J_w.T @ inertia @ at.J_w
            f += body.mass * at.J_v.T @ (G - at.a)
            f -= at.J_w.T @ (inertia @ at.alpha + np.cross(at.w, inertia @ at.w))
        for _, at, force in self.spring_forces(frames):
            f += at.J_v.T @ force
        return np.linalg.solve(M, f)

    def motion(self, end):
        """Return coordinates and rates (2 n,) at the end of a motion from coordinates of zero."""
        rates = np.concatenate([body.rates for body in self.bodies])

        def rate_of(t, y):
            return np.concatenate([y[len(rates) :], self.accelerations(y)])

        start = np.concatenate([0.0 * rates, rates])
        return solve_ivp(rate_of, (0.0, end), start, method="DOP853", rtol=1e-10, atol=1e-11).y[:, -1]

    def reaction(self, y, i):
        """Return force and moment (3,) about its point that the joint of body i transmits to it."""
        frames, second = self.frames(y), self.accelerations(y)
        outboard = {i}
        for j, body in enumerate(self.bodies):
            outboard |= {j} if body.parent in outboard else set()
        force, moment = np.zeros(3), np.zeros(3)
        for j in outboard:
            at, inertia = self.center(j, frames[j])
            needed = self.bodies[j].mass * (at.a + at.J_v @ second - G)
            force += needed
            moment += inertia @ (at.alpha + at.J_w @ second) + np.cross(at.w, inertia @ at.w)
            moment += np.cross(at.x - frames[i].x, needed)
        for j, at, given in self.spring_forces(frames):
            if j in outboard:
                force -= given
                moment -= np.cross(at.x - frames[i].x, given)
        return force, moment
