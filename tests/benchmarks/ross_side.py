"""Compare the whirl of random rotors with ROSS, a library of rotor dynamics.

    pip install ross-rotordynamics "plotly<6"
    python tests/benchmarks/ross_side.py 0 39      # the seeds of the first and the last rotor

A rotor has three to five cylindrical pieces, solid or hollow, one or two discs, and two or three bearings with
stiffness and damping that differ in two directions. Half of the bearings have coupled stiffness, with kxy and kyx of
opposite signs, as of an oil film: forces of signals here. The script compares the eigenvalues of the first modes at
rest and at two speeds, gyroscopic moments, shear and rotary inertia included. Values of both programs, of second order
in the size of an element, are extrapolated from two meshes. A difference is relative to the modulus.
"""

import sys

import numpy as np
import ross

import mecano

YOUNG, SHEAR, DENSITY = 211e9, 81.2e9, 7810.0
MESHES = (6, 12)  # elements of each piece
MODES = 12
AXIAL = 1e6  # N/m, of the first bearing


class Rotor:
    """A random rotor along z; station i is the start of piece i."""

    def __init__(self, seed):
        rng = np.random.default_rng(seed)
        pieces = int(rng.integers(3, 6))
        self.pieces = [(rng.uniform(0.08, 0.35), rng.uniform(0.015, 0.06), rng.choice([0.0, 0.5]))
                       for _ in range(pieces)]  # fmt: skip
        stations = pieces + 1
        self.discs = {int(i): (rng.uniform(1.0, 15.0), rng.uniform(0.002, 0.05))
                      for i in rng.choice(stations, int(rng.integers(1, 3)), replace=False)}  # fmt: skip
        at = sorted(int(i) for i in rng.choice(stations, int(rng.integers(2, 4)), replace=False))
        self.bearings = {i: self._bearing(rng) for i in at}
        self.speeds = (0.0, rng.uniform(20.0, 300.0), rng.uniform(300.0, 1200.0))

    def _bearing(self, rng):
        """Return (kxx, kxy, kyx, kyy) [N/m] and (cxx, cyy) [N s/m]."""
        k_x, k_y = 10 ** rng.uniform(5.5, 8.0, 2)
        coupled = rng.choice([0.0, 1.0]) * rng.uniform(0.0, 0.2) * min(k_x, k_y)
        return (k_x, coupled, -coupled * rng.uniform(0.5, 1.0), k_y), 10 ** rng.uniform(1.0, 3.5, 2)


def ross_values(rotor, mesh):
    """Return the eigenvalues [1/s] at each speed, and the shear coefficients of the pieces."""
    steel = ross.Material("steel", rho=DENSITY, E=YOUNG, G_s=SHEAR)
    pieces = [ross.ShaftElement(length / mesh, bore * diameter, diameter, material=steel)
              for length, diameter, bore in rotor.pieces]  # fmt: skip
    shaft = [ross.ShaftElement(e.L, e.idl, e.odl, material=steel) for e in pieces for _ in range(mesh)]
    discs = [ross.DiskElement(n=i * mesh, m=m, Id=0.6 * polar, Ip=polar) for i, (m, polar) in rotor.discs.items()]
    first = min(rotor.bearings)
    bearings = [ross.BearingElement(n=i * mesh, kxx=k[0], kxy=k[1], kyx=k[2], kyy=k[3], cxx=c[0], cyy=c[1],
                                    kzz=AXIAL if i == first else 0.0)
                for i, (k, c) in rotor.bearings.items()]  # fmt: skip
    whole = ross.Rotor(shaft, discs, bearings)
    return [np.linalg.eigvals(whole.A(speed)) for speed in rotor.speeds], [float(e.kappa) for e in pieces]


def deck(rotor, shear, speed, mesh):
    """Return the deck of the rotor at a ``speed`` [rad/s]; ``shear``: coefficients of the pieces."""
    ends = np.cumsum([0.0, *(length for length, _, _ in rotor.pieces)])
    sections = {f"piece_{i}": section(d, bore, shear[i]) for i, (_, d, bore) in enumerate(rotor.pieces)}
    elements = {name: {"type": "beam", "nodes": [f"station_{i}", f"station_{i + 1}"], "section": name,
                       "up": [1, 0, 0], "mesh": mesh} for i, name in enumerate(sections)}  # fmt: skip
    elements |= {f"disc_{i}": {"type": "rigid_body", "node": f"station_{i}", "mass": mass,
                               "inertia": [0.6 * polar, 0.6 * polar, polar]}
                 for i, (mass, polar) in rotor.discs.items()}  # fmt: skip
    elements |= {f"bearing_{i}": {"type": "bushing", "nodes": ["ground", f"station_{i}"],
                                  "stiffness": [k[0], k[3], AXIAL if i == min(rotor.bearings) else 0.0, 0, 0, 0],
                                  "damping": [*c, 0, 0, 0, 0]} for i, (k, c) in rotor.bearings.items()}  # fmt: skip
    loads = {f"film_{i}_{along}": {"type": "force", "node": f"station_{i}", "direction": direction,
                                   "value": f"{-k[entry]:.17g} * station_{i}.position.{by}"}
             for i, (k, _) in rotor.bearings.items()
             for along, direction, entry, by in (("x", [1, 0, 0], 1, "y"), ("y", [0, 1, 0], 2, "x"))}  # fmt: skip
    turning = {"initial": {"steady": {"angular_velocity": [0, 0, speed], "about": [0, 0, 0]}}} if speed else {}
    return mecano.Deck({
        "gravity": "none", "sections": sections, "elements": elements, "loads": loads,
        "nodes": {f"station_{i}": {"position": [0, 0, z]} for i, z in enumerate(ends)}, "time": {"end": 1, "step": 0.1},
    } | turning)  # fmt: skip


def section(diameter, bore, shear):
    """Return the section of a tube with a ``bore`` in diameters."""
    area, second = np.pi * diameter**2 / 4 * (1 - bore**2), np.pi * diameter**4 / 64 * (1 - bore**4)
    return {
        "type": "stiffness", "EA": YOUNG * area, "GA2": shear * SHEAR * area, "GA3": shear * SHEAR * area,
        "GJ": 2 * SHEAR * second, "EI2": YOUNG * second, "EI3": YOUNG * second, "mass_per_length": DENSITY * area,
        "rotary_inertia": [2 * DENSITY * second, DENSITY * second, DENSITY * second],
    }  # fmt: skip


def extrapolated(coarse, fine, near):
    """Return the limit (m,) of the eigenvalues nearest to those in ``near`` (m,), and the error of the fine ones."""
    a, b = (values[np.argmin(np.abs(values[:, None] - near), axis=0)] for values in (coarse, fine))
    limit = b + (b - a) / 3.0
    return limit, np.abs(b - limit) / np.abs(limit)


def differences(seed):
    """Return the largest relative difference of the eigenvalues at each speed, and the errors of the finer meshes."""
    rotor = Rotor(seed)
    (coarse, shear), (fine, _) = (ross_values(rotor, mesh) for mesh in MESHES)
    found = []
    for i, speed in enumerate(rotor.speeds):
        whirl = fine[i][fine[i].imag > 1.0]  # not the free rotation
        near = whirl[np.argsort(np.abs(whirl))][:MODES]
        ours = [np.asarray(mecano.modes(deck(rotor, shear, speed, m), number=4 * MODES).eigenvalues) for m in MESHES]
        a, error_a = extrapolated(*ours, near)
        b, error_b = extrapolated(coarse[i], fine[i], near)
        found.append((np.max(np.abs(a - b) / np.abs(b)), error_a.max(), error_b.max()))
    return rotor.speeds, found


def main(first, last):
    """Print the differences of each rotor at its speeds, and the largest of all."""
    worst = 0.0
    for seed in range(first, last + 1):
        for speed, (difference, error, error_ross) in zip(*differences(seed), strict=True):
            print(
                f"{seed} at {speed:.0f} rad/s: {difference:.1e} (meshes: {error:.1e}, ROSS {error_ross:.1e})",
                flush=True,
            )
            worst = max(worst, difference)
    print(f"at most {worst:.1e}")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
