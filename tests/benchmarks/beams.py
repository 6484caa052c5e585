"""A falling flexible pendulum (inputs/flexible_pendulum.yaml) beside Exudyn: CPU per step, height of the tip after 1 s.

    python tests/benchmarks/beams.py [elements ...]

Steps of 1 ms, one thread, best of three; beside them the longest steps with which the tip of mecano is no farther off
than that of the other element, and the ratio of the whole runs then. The limits of the height, from fine meshes and
steps: 0.007979 m with shear and rotary inertia (mecano, Exudyn's exact beam), 0.007782 m without (ANCF cable). Recorded
in docs/benchmarks.md.
"""

import contextlib
import math
import os
import sys
import time
from pathlib import Path

for _variable in ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(_variable, "1")

import numpy as np

from mecano.analyses.prepare import integrator_of, prepare
from mecano.deck.read import read_deck

DECK = Path(__file__).parents[2] / "inputs" / "flexible_pendulum.yaml"
STEP, STEPS, REPETITIONS = 1e-3, 1000, 3
LONGER = 10e-3, 8e-3, 5e-3, 4e-3, 2.5e-3, 2e-3, 1.6e-3, 1.25e-3, STEP  # [s]
LENGTH, DIAMETER, E, NU, DENSITY, GRAVITY = 1.0, 0.01, 1e8, 0.3, 1100.0, 9.81
ELEMENTS, ELEMENT_KINDS = (8, 64, 512), ("exact beam", "ANCF cable")
LIMITS = {"mecano": 0.007979, "exact beam": 0.007979, "ANCF cable": 0.007782}


def mecano(n, step=STEP):
    """CPU [s] for one second of motion and error of the height of the tip [m] with n elements."""
    prepared = prepare(read_deck(DECK, (f"elements.rod.mesh={n}", f"time.step={step}")))
    tip = [node.name for node in prepared.system.nodes].index("tip")
    spent = []
    for _ in range(REPETITIONS):
        integrator = integrator_of(prepared)
        run = integrator.begin(prepared.state, step)
        start = time.process_time()
        run = integrator.to(STEP * STEPS, run)
        spent.append(time.process_time() - start)
    return min(spent), abs(run.motion.z[prepared.system.numbering.x[tip] + 2] - LIMITS["mecano"])


def longest(n, error):
    """The longest step [s] with which the tip of mecano is no farther off than ``error`` [m], and the CPU [s] then."""
    for step in LONGER:
        spent, own = mecano(n, step)
        if own <= error:
            return step, spent
    return STEP, math.nan


def exudyn(n, element):
    """The same in Exudyn, sparse solver and modified Newton; None where it is not installed or finds no solution."""
    sys.exudynFast = True
    try:
        import exudyn as exu
        from exudyn import utilities as lib
    except ImportError:
        return None
    spent = []
    for _ in range(REPETITIONS):
        container = exu.SystemContainer()
        mbs = container.AddSystem()
        tip = (_exact if element == "exact beam" else _cable)(mbs, n, exu, lib)
        mbs.Assemble()
        given = _settings(exu)
        start = time.process_time()
        done = False
        with contextlib.suppress(ValueError, exu.SolverError):
            done = mbs.SolveDynamic(given, showHints=False)
        if not done:
            return None
        spent.append(time.process_time() - start)
    height = mbs.GetNodeOutput(tip, exu.OutputVariableType.Position)[2]
    return min(spent), abs(height - LIMITS[element])


def _settings(exu):
    given = exu.SimulationSettings()
    integration = given.timeIntegration
    integration.numberOfSteps, integration.endTime, integration.adaptiveStep = STEPS, STEP * STEPS, False
    integration.generalizedAlpha.spectralRadius = 0.8
    integration.newton.useModifiedNewton = True
    integration.newton.relativeTolerance = 1e-5  # 1e-8, the default, is never met with 512 elements
    given.linearSolver.solverType = exu.LinearSolverType.EigenSparse
    given.solution.file.write = False
    given.parallel.numberOfThreads = 1
    return given


def _exact(mbs, n, exu, lib):
    area, bending = math.pi * DIAMETER**2 / 4, math.pi * DIAMETER**4 / 64
    shear, k = E / (2 * (1 + NU)), 6 * (1 + NU) / (7 + 6 * NU)
    section, piece = exu.BeamSection(), LENGTH / n
    stiffness = [E * area, k * shear * area, k * shear * area, 2 * shear * bending, E * bending, E * bending]
    section.stiffnessMatrix, section.massPerLength = np.diag(stiffness), DENSITY * area
    section.inertia = DENSITY * np.diag([2 * bending, bending, bending])
    nodes = [mbs.AddNode(lib.NodeRigidBodyEP(referenceCoordinates=[piece * i, 0, 0, 1, 0, 0, 0])) for i in range(n + 1)]
    for ends in zip(nodes[:-1], nodes[1:], strict=True):
        beam = lib.ObjectBeamGeometricallyExact(nodeNumbers=list(ends), physicsLength=piece, sectionData=section)
        mbs.AddObject(beam)
    for i, node in enumerate(nodes):  # this beam takes no load of its mass
        weight = (0.5 if i in (0, n) else 1.0) * DENSITY * area * piece * GRAVITY
        marker = mbs.AddMarker(lib.MarkerNodePosition(nodeNumber=node))
        mbs.AddLoad(lib.LoadForceVector(markerNumber=marker, loadVector=[0, 0, -weight]))
    ground = mbs.AddMarker(lib.MarkerBodyRigid(bodyNumber=mbs.AddObject(lib.ObjectGround())))
    pin = mbs.AddMarker(lib.MarkerNodeRigid(nodeNumber=nodes[0]))
    mbs.AddObject(lib.GenericJoint(markerNumbers=[ground, pin], constrainedAxes=[1, 1, 1, 1, 0, 1]))
    return nodes[-1]


def _cable(mbs, n, exu, lib):
    import exudyn.beams

    area, bending = math.pi * DIAMETER**2 / 4, math.pi * DIAMETER**4 / 64
    cable = lib.ObjectANCFCable(
        physicsMassPerLength=DENSITY * area, physicsBendingStiffness=E * bending, physicsAxialStiffness=E * area,
        physicsLength=LENGTH / n,
    )  # fmt: skip
    nodes, *_ = exudyn.beams.GenerateStraightLineANCFCable(
        mbs, [0, 0, 0], [LENGTH, 0, 0], n, cable, massProportionalLoad=[0, 0, -GRAVITY],
        fixedConstraintsNode0=[1, 1, 1, 0, 0, 0],
    )  # fmt: skip
    return nodes[-1]


def measured(elements):
    """Yield for each number of elements and each element of Exudyn what is in one row of the table."""
    for n in elements:
        own, error = mecano(n)
        for element in ELEMENT_KINDS:
            found = {"elements": n, "us_per_step": 1e6 * own / STEPS, "error": error, "element": element}
            if theirs := exudyn(n, element):
                spent, off = theirs
                step, equal = longest(n, off)
                found |= {"exudyn": 1e6 * spent / STEPS, "exudyn_error": off, "ratio": own / spent}
                found |= {"equal_step": step, "equal_ratio": equal / spent}
            yield found


def main():
    for row in measured([int(text) for text in sys.argv[1:]] or ELEMENTS):
        print(
            f"{row['elements']:4d} elements: mecano {row['us_per_step']:7.1f} us/step, tip off by {row['error']:.1e} m"
        )
        if "exudyn" in row:
            us, off = row["exudyn"], row["exudyn_error"]
            print(f"     Exudyn, {row['element']}: {us:7.1f} us/step, {off:.1e} m, ratio {row['ratio']:.2f}; ", end="")
            print(f"with steps of {1e3 * row['equal_step']:g} ms {row['equal_ratio']:.2f}")


if __name__ == "__main__":
    main()
