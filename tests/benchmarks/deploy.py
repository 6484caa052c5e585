"""A folded skeleton that springs open (7 ribs of 3 flexible segments, 84 beams, 21 sprung hinges) beside Exudyn.

    python tests/benchmarks/deploy.py

mecano takes 210 fixed steps of 5 ms. Exudyn finds no solution with those: it may make them smaller and has the best of
the settings tried, which are printed. CPU of the whole solution on one thread, median of five in turn, and the distance
of the first tip from that of mecano with much smaller steps. Recorded in docs/benchmarks.md.
"""

import contextlib
import math
import os
import statistics
import sys
import time
import warnings

for _variable in ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(_variable, "1")

import numpy as np
import yaml

from mecano.analyses.prepare import integrator_of, prepare
from mecano.deck.read import deck_of_bytes

RIBS, SEGMENTS, BEAMS = 7, 3, 4
LENGTH, HUB = 1.0, 0.3  # of a segment; radius of the ring of the first hinges [m]
FOLD = (1.45, -1.45, 1.45)  # tilt of the segments of a rib [rad]
E, NU, DENSITY, OUTER, INNER = 70e9, 0.33, 1600.0, 0.03, 0.027
AREA, BENDING = math.pi / 4 * (OUTER**2 - INNER**2), math.pi / 64 * (OUTER**4 - INNER**4)
SHEAR = E / (2 * (1 + NU))
SPRING, DAMPER = 2.0, 0.5  # of the hinges [N m/rad, N m s/rad]
STEP, STEPS, RHO, REPETITIONS = 5e-3, 210, 0.6, 5


def about_z(angle):
    """Rotation matrix (3, 3)."""
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])


def about_y(angle):
    """Rotation matrix (3, 3)."""
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])


def segments():
    """(rib, number, attitude of the rib (3, 3), attitude (3, 3), start (3,)) of each segment."""
    for rib in range(RIBS):
        turned = about_z(2 * math.pi * rib / RIBS)
        start = turned @ [HUB, 0, 0]
        for i in range(SEGMENTS):
            R = turned @ about_y(-FOLD[i])
            yield rib, i, turned, R, start
            start = start + LENGTH * R[:, 0]


def deck(step):
    """The deck as bytes."""
    nodes, elements, joints = {}, {}, {}
    for rib, i, turned, R, start in segments():
        name = f"{rib}_{i}"
        nodes[f"a{name}"], nodes[f"b{name}"] = (
            {"position": [float(x) for x in end]} for end in (start, start + LENGTH * R[:, 0])
        )
        elements[f"segment{name}"] = {
            "type": "beam", "nodes": [f"a{name}", f"b{name}"], "section": "tube", "mesh": BEAMS,
        }  # fmt: skip
        before = f"b{rib}_{i - 1}" if i else "ground"
        joints[f"hinge{name}"] = {
            "type": "hinge", "nodes": [before, f"a{name}"], "axis": [float(x) for x in turned[:, 1]],
            "turning_law": {"spring": {"stiffness": SPRING}, "damper": {"coefficient": DAMPER}},
            "natural_angle": FOLD[i] - (FOLD[i - 1] if i else 0.0),
        }  # fmt: skip
    tube = {
        "type": "stiffness", "EA": E * AREA, "GA2": 0.5 * SHEAR * AREA, "GA3": 0.5 * SHEAR * AREA,
        "GJ": 2 * SHEAR * BENDING, "EI2": E * BENDING, "EI3": E * BENDING, "mass_per_length": DENSITY * AREA,
        "rotary_inertia": [2 * DENSITY * BENDING, DENSITY * BENDING, DENSITY * BENDING],
    }  # fmt: skip
    model = {"gravity": [0, 0, 0], "sections": {"tube": tube}, "nodes": nodes, "elements": elements, "joints": joints}
    timing = {"end": STEP * STEPS, "step": step, "rho_inf": RHO}
    return yaml.safe_dump({"mecano": 1, **model, "time": timing}, sort_keys=False).encode()


def mecano(step=STEP):
    """A function that solves once: (CPU [s], first tip (3,), accepted steps)."""
    prepared = prepare(deck_of_bytes(deck(step), "deploy"))
    tip = prepared.system.numbering.x[[node.name for node in prepared.system.nodes].index(f"b0_{SEGMENTS - 1}")]

    def solve():
        integrator = integrator_of(prepared)
        start = time.process_time()
        run = integrator.to(STEP * STEPS, integrator.begin(prepared.state, step))
        return time.process_time() - start, run.motion.z[tip : tip + 3], run.steps

    return solve


def exudyn(newton, tolerance, adaptive=True):
    """The same in Exudyn; None where it finds no solution."""
    import exudyn as exu
    from exudyn import utilities as lib

    mbs = exu.SystemContainer().AddSystem()
    tip = _skeleton(mbs, exu, lib)
    mbs.Assemble()
    given = exu.SimulationSettings()
    integration = given.timeIntegration
    integration.numberOfSteps, integration.endTime, integration.adaptiveStep = STEPS, STEP * STEPS, adaptive
    integration.generalizedAlpha.spectralRadius = RHO
    integration.newton.useModifiedNewton, integration.newton.relativeTolerance = newton == "modified", tolerance
    given.linearSolver.solverType = exu.LinearSolverType.EigenSparse
    given.solution.file.write = False
    given.parallel.numberOfThreads = 1
    start, done = time.process_time(), False
    with contextlib.suppress(ValueError, exu.SolverError):
        done = mbs.SolveDynamic(given, showHints=False)
    spent = time.process_time() - start
    return (spent, np.array(mbs.GetNodeOutput(tip, exu.OutputVariableType.Position))) if done else None


def _skeleton(mbs, exu, lib):
    """Build it; the node of the first tip."""
    section = exu.BeamSection()
    shear, bending = 0.5 * SHEAR * AREA, E * BENDING
    section.stiffnessMatrix = np.diag([E * AREA, shear, shear, 2 * SHEAR * BENDING, bending, bending])
    section.massPerLength = DENSITY * AREA
    section.inertia = DENSITY * np.diag([2 * BENDING, BENDING, BENDING])
    ground, to_y, tips = mbs.CreateGround(), lib.RotationMatrixX(-0.5 * math.pi), {}
    for rib, i, turned, R, at in segments():
        attitude = list(lib.RotationMatrix2EulerParameters(R))
        nodes = [
            mbs.AddNode(lib.NodeRigidBodyEP(referenceCoordinates=[*(at + LENGTH * j / BEAMS * R[:, 0]), *attitude]))
            for j in range(BEAMS + 1)
        ]
        for ends in zip(nodes[:-1], nodes[1:], strict=True):
            mbs.AddObject(
                lib.ObjectBeamGeometricallyExact(
                    nodeNumbers=list(ends), physicsLength=LENGTH / BEAMS, sectionData=section
                )
            )
        if i:
            held, frame = mbs.AddMarker(lib.MarkerNodeRigid(nodeNumber=tips[rib])), to_y
        else:
            held, frame = mbs.AddMarker(lib.MarkerBodyRigid(bodyNumber=ground, localPosition=list(at))), turned @ to_y
        markers = [held, mbs.AddMarker(lib.MarkerNodeRigid(nodeNumber=nodes[0]))]
        frames = {"rotationMarker0": frame, "rotationMarker1": to_y}
        mbs.AddObject(lib.ObjectJointRevoluteZ(markerNumbers=markers, **frames))
        turns = mbs.AddNode(lib.NodeGenericData(numberOfDataCoordinates=1, initialCoordinates=[0]))
        spring = {"stiffness": SPRING, "damping": DAMPER, "offset": 0.0}
        mbs.AddObject(lib.TorsionalSpringDamper(markerNumbers=markers, nodeNumber=turns, **spring, **frames))
        tips[rib] = nodes[-1]
    return tips[0]


def best():
    """Print every setting of Exudyn tried; the fastest that finds a solution."""
    found = {}
    for given in [(newton, tolerance) for newton in ("full", "modified") for tolerance in (1e-8, 1e-6, 1e-5, 1e-4)]:
        if result := exudyn(*given):
            found[given] = result[0]
        print("Exudyn", *given, f"{found[given]:.2f} s, tip {result[1]}" if result else "finds no solution", flush=True)
    return min(found, key=found.get)


def main():
    """Everything that the docstring says."""
    warnings.simplefilter("ignore", DeprecationWarning)  # Exudyn renames arguments
    _, fine, _ = mecano(STEP / 32)()
    solve = mecano()
    solve()
    try:
        setting = best()
        print("Exudyn with fixed steps:", "a solution" if exudyn(*setting, adaptive=False) else "no solution")
    except ImportError:
        setting = None
    rounds = [(solve(), exudyn(*setting) if setting else (math.nan, np.full(3, math.nan))) for _ in range(REPETITIONS)]
    own, other = (statistics.median(spent for spent, *_ in one) for one in zip(*rounds, strict=True))
    (_, tip, steps), (_, their) = rounds[0]
    print(f"mecano {own:.3f} s, {steps} steps, tip off by {np.linalg.norm(tip - fine):.1e} m")
    if setting:
        print(
            f"Exudyn {other:.3f} s {setting}, tip off by {np.linalg.norm(their - fine):.1e} m; ratio {own / other:.2f}"
        )


if __name__ == "__main__":
    sys.exudynFast = True
    main()
