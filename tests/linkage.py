"""The planar four-bar linkage in closed form, the reference of the deck four_bar.yaml."""

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

GRAVITY = 9.81


@dataclass(frozen=True)
class FourBar:
    """Uniform thin bars; angles from x towards z [rad], the crank turning about the origin."""

    ground: float = 1.0  # [m]
    crank: float = 0.3
    coupler: float = 0.9
    rocker: float = 0.7
    density: float = 2.0  # [kg/m]

    def angles(self, theta):
        """Coupler and rocker angle (2, ...) of the crank angle; the branch with the coupler above the ground link."""
        x, z = self.ground - self.crank * np.cos(theta), -self.crank * np.sin(theta)
        distance, direction = np.hypot(x, z), np.arctan2(z, x)
        cosine = (self.coupler**2 + distance**2 - self.rocker**2) / (2.0 * self.coupler * distance)
        coupler = direction + np.arccos(cosine)
        x_c = self.coupler * np.cos(coupler) - x
        return np.array([coupler, np.arctan2(self.coupler * np.sin(coupler) - z, x_c)])

    def rates(self, theta):
        """First and second derivatives of the three angles by the crank angle, (2, 3)."""
        coupler, rocker = self.angles(theta)
        lengths = np.array([self.crank, self.coupler, -self.rocker])
        arms = lengths * np.exp(1j * np.array([theta, coupler, rocker]))  # they close: their sum is the ground link
        matrix = np.array([arms[1:].real, arms[1:].imag])
        first = np.array([1.0, *np.linalg.solve(matrix, [-arms[0].real, -arms[0].imag])])
        rest = 1j * (arms @ first**2)
        return np.array([first, [0.0, *np.linalg.solve(matrix, [-rest.real, -rest.imag])]])

    def acceleration(self, theta, rate):
        """Second time derivative of the crank angle under gravity (Kane's equation)."""
        coupler, rocker = self.angles(theta)
        first, second = self.rates(theta)
        turns = np.exp(1j * np.array([theta, coupler, rocker]))
        lengths = np.array([self.crank, self.coupler, self.rocker])
        half = 0.5 * lengths * turns
        partial, bend = 1j * half * first, half * (1j * second - first**2)
        base_partial = np.array([0.0, 2j * half[0], 0.0])  # the coupler stands on the end of the crank
        base_bend = np.array([0.0, -2.0 * half[0], 0.0])
        velocity, bend = partial + base_partial, bend + base_bend
        mass = self.density * lengths
        inertia = mass * lengths**2 / 12.0
        resisting = mass @ np.abs(velocity) ** 2 + inertia @ first**2
        turning = mass @ (bend * velocity.conj()).real + inertia @ (first * second)
        return (-GRAVITY * mass @ velocity.imag - turning * rate**2) / resisting

    def motion(self, times, theta=0.0, rate=0.0):
        """Crank angle and its rate (n, 2) at ascending ``times`` (n,) from 0, under gravity, to 1e-11."""
        found = solve_ivp(
            lambda t, y: [y[1], self.acceleration(*y)], (0.0, times[-1]), [theta, rate],
            method="DOP853", rtol=1e-12, atol=1e-13, t_eval=times,
        )  # fmt: skip
        return found.y.T
