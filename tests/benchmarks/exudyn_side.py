"""The cases in Exudyn (pip install exudyn), as its users write and tune them: the same bodies, joints and steps.

Exudyn needs settings for the solution of a model. ``CANDIDATES`` are the settings that its manual offers;
``run.py tune CASE``
tries them all; ``BEST`` names the fastest that keeps the accuracy.
"""

import contextlib
import math
import sys
import time
import warnings
from dataclasses import dataclass, replace

import numpy as np
from cases import DISC, GEAR, GRAVITY, LENGTH, MASS, THICKNESS, TOP_SPEED

sys.exudynFast = True  # the module compiled without range checks
with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    import exudyn as exu
    from exudyn import utilities as lib

NODE_TYPES = {
    "Euler parameters": exu.NodeType.RotationEulerParameters,
    "rotation vector": exu.NodeType.RotationRotationVector,
    "Tait-Bryan": exu.NodeType.RotationRxyz,
}
SOLVERS = {
    "dense": exu.LinearSolverType.EXUdense,
    "full pivoting": exu.LinearSolverType.EigenDense,
    "sparse": exu.LinearSolverType.EigenSparse,
    "sparse symmetric": exu.LinearSolverType.EigenSparseSymmetric,
}


@dataclass(frozen=True)
class Settings:
    """How Exudyn is asked to solve a model."""

    solver: str = "sparse"
    modified: bool = True  # modified Newton
    relative: float = 1e-5  # tolerance of Newton; the default of Exudyn is 1e-8
    absolute: float = 1e-10
    node: str = "Euler parameters"
    method: str = "index 3"  # or "trapezoidal", which is index 2
    rho: float = 0.9
    redundant: bool = False  # continue with a singular matrix
    model: str = ""  # if not that of the case
    tyre: str = "own"  # "script": the law of mecano's tyre as a Python function


BEST = {
    "chain-1": Settings("dense", modified=False, method="trapezoidal"),
    "chain-10": Settings(node="Tait-Bryan", method="trapezoidal"),
    "chain-100": Settings(method="trapezoidal"),
    "chain-1000": Settings(method="trapezoidal"),
    "four-bar-1-planar": Settings("dense", modified=False, method="trapezoidal", rho=0.95, model="four_bar_planar"),
    "four-bar-1-spatial": Settings(
        "full pivoting", modified=False, node="Tait-Bryan", method="trapezoidal", rho=0.95, model="four_bar_isostatic"
    ),
    "four-bar-10-planar": Settings(modified=False, method="trapezoidal", rho=0.95, model="four_bar_planar"),
    "four-bar-10-spatial": Settings(modified=False, method="trapezoidal", rho=0.95, model="four_bar_isostatic"),
    "four-bar-10": Settings("full pivoting", node="Tait-Bryan", rho=0.95, redundant=True),
    "rolling-disc": Settings("dense", modified=False, node="rotation vector", method="trapezoidal"),
    "gear-drop": Settings("dense", node="Tait-Bryan", rho=0.8),
}


def candidates(case):
    """All settings worth trying for a case."""
    base = BEST[case.name]
    solvers = ["full pivoting"] if base.redundant else list(SOLVERS)[:3] if case.size <= 10 else ["sparse"]
    for solver in solvers:
        for node in NODE_TYPES:
            for modified in (True, False):
                for relative in (1e-5, 1e-8):
                    for method in ("index 3", "trapezoidal"):
                        yield replace(
                            base, solver=solver, node=node, modified=modified, relative=relative, method=method
                        )  # fmt: skip


def precise(case):
    """Settings of the reference: full Newton, tight tolerances; isostatic hinges, which Exudyn solves anyway."""
    solver = "sparse" if case.model == "four_bar" else BEST[case.name].solver
    tight = replace(BEST[case.name], solver=solver, modified=False, relative=1e-10, absolute=1e-12)
    if case.model != "four_bar":
        return tight
    return replace(tight, redundant=False, method="index 3", model="four_bar_isostatic")


def same_law(settings):
    """The settings with the tyre law of mecano, for a converged solution that both codes must agree on."""
    return replace(settings, tyre="script")


def _bar():
    density = MASS / (LENGTH * THICKNESS**2)
    return lib.InertiaCuboid(density=density, sideLengths=[LENGTH, THICKNESS, THICKNESS])


def _hinge(mbs, bodies, position, axis):
    mbs.CreateRevoluteJoint(bodyNumbers=bodies, position=position, axis=axis, useGlobalFrame=True, show=False)


def chain(mbs, n, settings):
    """Bodies of the chain."""
    bodies, held = [], mbs.CreateGround()
    for i in range(n):
        body = mbs.CreateRigidBody(
            referencePosition=[(i + 0.5) * LENGTH, 0, 0], inertia=_bar(), gravity=[0, 0, -GRAVITY],
            nodeType=NODE_TYPES[settings.node],
        )  # fmt: skip
        _hinge(mbs, [held, body], [i * LENGTH, 0, 0], [0, 1, 0])
        bodies.append(body)
        held = body
    return bodies


def _bars(n):
    """(centre, angle [rad], velocity, rate of turn) of the cranks, then of the bars between them."""
    L, v = LENGTH, TOP_SPEED
    cranks = [([i * L, 0.5 * L, 0], 0.5 * math.pi, [0.5 * v, 0, 0], -v / L) for i in range(n + 1)]
    return cranks + [([(i + 0.5) * L, L, 0], 0.0, [v, 0, 0], 0.0) for i in range(n)]


def _spatial(mbs, n, settings, last):
    """A four-bar in space; ``last(bodies, place)`` joins the right end of each bar to the next crank."""
    ground, bodies = mbs.CreateGround(), []
    for place, angle, velocity, turning in _bars(n):
        c, s = math.cos(angle), math.sin(angle)
        body = mbs.CreateRigidBody(
            referencePosition=place, referenceRotationMatrix=np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]),
            initialVelocity=velocity, initialAngularVelocity=[0, 0, turning], inertia=_bar(),
            gravity=[0, -GRAVITY, 0], nodeType=NODE_TYPES[settings.node],
        )  # fmt: skip
        bodies.append(body)
    cranks, bars = bodies[: n + 1], bodies[n + 1 :]
    for i, crank in enumerate(cranks):
        _hinge(mbs, [ground, crank], [i * LENGTH, 0, 0], [0, 0, 1])
    for i, bar in enumerate(bars):
        _hinge(mbs, [cranks[i], bar], [i * LENGTH, LENGTH, 0], [0, 0, 1])
        last([bar, cranks[i + 1]], [(i + 1) * LENGTH, LENGTH, 0])
    return bodies


def four_bar(mbs, n, settings):
    """Hinges everywhere, which are redundant."""
    return _spatial(mbs, n, settings, lambda bodies, place: _hinge(mbs, bodies, place, [0, 0, 1]))


def four_bar_isostatic(mbs, n, settings):
    """The last joint of each window holds two coordinates only."""

    def last(bodies, place):
        mbs.CreateGenericJoint(
            bodyNumbers=bodies, position=place, constrainedAxes=[1, 1, 0, 0, 0, 0], useGlobalFrame=True, show=False
        )

    return _spatial(mbs, n, settings, last)


def four_bar_planar(mbs, n, settings):
    """Bodies with three coordinates each."""
    ground, bodies = mbs.AddObject(lib.ObjectGround()), []
    for place, angle, velocity, turning in _bars(n):
        rates = [*velocity[:2], turning]
        node = mbs.AddNode(lib.NodeRigidBody2D(referenceCoordinates=[*place[:2], angle], initialVelocities=rates))
        inertia = MASS * (LENGTH**2 + THICKNESS**2) / 12.0
        bodies.append(mbs.AddObject(lib.RigidBody2D(nodeNumber=node, physicsMass=MASS, physicsInertia=inertia)))
        marker = mbs.AddMarker(lib.MarkerBodyMass(bodyNumber=bodies[-1]))
        mbs.AddLoad(lib.LoadMassProportional(markerNumber=marker, loadVector=[0, -GRAVITY, 0]))

    def at(body, place):
        return mbs.AddMarker(lib.MarkerBodyPosition(bodyNumber=body, localPosition=place))

    def pin(a, b):
        mbs.AddObject(lib.RevoluteJoint2D(markerNumbers=[a, b]))

    left, right = [-0.5 * LENGTH, 0, 0], [0.5 * LENGTH, 0, 0]
    for i in range(n + 1):
        pin(at(ground, [i * LENGTH, 0, 0]), at(bodies[i], left))
    for i in range(n):
        bar = bodies[n + 1 + i]
        pin(at(bodies[i], right), at(bar, left))
        pin(at(bar, right), at(bodies[i + 1], right))
    return bodies


def gear_drop(mbs, n, settings):
    """Top, slider, wheel."""
    g = GEAR
    height = g.radius + g.clearance
    ground = mbs.CreateGround()

    def body(z, mass, inertia):
        return mbs.CreateRigidBody(
            referencePosition=[0, 0, z], initialVelocity=[g.speed, 0, -g.sink], gravity=[0, 0, -GRAVITY],
            inertia=lib.RigidBodyInertia(mass, np.diag(inertia)), nodeType=NODE_TYPES[settings.node],
        )  # fmt: skip

    top = body(height + g.strut, g.top_mass, [g.top_inertia] * 3)
    slider = body(height, g.slider_mass, g.slider_inertia)
    wheel = body(height, g.wheel_mass, g.wheel_inertia)
    mbs.CreateGenericJoint(
        bodyNumbers=[ground, top], position=[0, 0, 0], constrainedAxes=[0, 1, 0, 1, 1, 1], useGlobalFrame=False,
        show=False,
    )  # fmt: skip
    axle = [0, 0, height]
    mbs.CreatePrismaticJoint(
        bodyNumbers=[top, slider], position=axle, axis=[0, 0, 1], useGlobalFrame=True, show=False
    )  # fmt: skip
    mbs.CreateSpringDamper(
        bodyNumbers=[top, slider], referenceLength=g.strut, stiffness=g.stiffness, damping=g.damping, show=False
    )
    _hinge(mbs, [slider, wheel], axle, [0, 1, 0])
    (_script_tyre if settings.tyre == "script" else _own_tyre)(mbs, ground, wheel)
    return [top, slider, wheel]


def _own_tyre(mbs, ground, wheel):
    """The disc of Exudyn: friction acts at the undeformed radius, otherwise the law of mecano's tyre."""
    mbs.CreateRollingDiscPenalty(
        bodyNumbers=[ground, wheel], axisPosition=[0, 0, 0], axisVector=[0, 1, 0], discRadius=GEAR.radius,
        contactStiffness=GEAR.tyre, contactDamping=0.0, dryFriction=[GEAR.friction] * 2,
        dryFrictionProportionalZone=GEAR.slip, useLinearProportionalZone=False, show=False,
    )  # fmt: skip


def _script_tyre(mbs, ground, wheel):
    """The law of mecano's tyre, friction at the deformed radius, in Python."""
    markers = [mbs.AddMarker(lib.MarkerBodyRigid(bodyNumber=body)) for body in (ground, wheel)]
    data = mbs.AddNode(lib.NodeGenericData(numberOfDataCoordinates=1, initialCoordinates=[0]))

    def force(mbs, t, item, position, rotation, velocity, turning, *constants):
        height = position[2]
        load = GEAR.tyre * max(0.0, GEAR.radius - height)
        ratio = (velocity[0] - turning[1] * height) / GEAR.slip
        shape = math.copysign(1.0, ratio) if abs(ratio) >= 1.0 else ratio * (2.0 - abs(ratio))
        friction = GEAR.friction * shape * load
        return [friction, 0, -load, 0, -friction * height, 0]  # on the ground; the opposite on the wheel

    mbs.AddObject(
        lib.RigidBodySpringDamper(
            markerNumbers=markers, nodeNumber=data, stiffness=np.zeros((6, 6)), damping=np.zeros((6, 6)),
            springForceTorqueUserFunction=force,
        )
    )  # fmt: skip


def rolling_disc(mbs, n, settings):
    """The disc, held by constraints on velocities."""
    d = DISC
    R = np.array(lib.RotationMatrixX(d.lean))
    centre, turning = R @ [0, 0, d.radius], R @ [0, d.spin, 0] + [0, 0, d.turning]
    disc = mbs.CreateRigidBody(
        referencePosition=centre, referenceRotationMatrix=R, initialVelocity=np.cross(turning, centre),
        initialAngularVelocity=turning, inertia=lib.RigidBodyInertia(d.mass, np.diag(d.inertia)),
        gravity=[0, 0, -GRAVITY], nodeType=NODE_TYPES[settings.node],
    )  # fmt: skip
    mbs.CreateRollingDisc(
        bodyNumbers=[mbs.CreateGround(), disc], axisPosition=[0, 0, 0], axisVector=[0, 1, 0], discRadius=d.radius,
        planePosition=[0, 0, 0], planeNormal=[0, 0, 1], constrainedAxes=[1, 1, 1], show=False,
    )  # fmt: skip
    return [disc]


MODELS = {
    "chain": chain, "four_bar": four_bar, "four_bar_isostatic": four_bar_isostatic, "four_bar_planar": four_bar_planar,
    "gear_drop": gear_drop, "rolling_disc": rolling_disc,
}  # fmt: skip


class Exudyn:
    """A case in Exudyn, built anew for every run."""

    def __init__(self, case, settings=None, step=None):
        self.case, self.step = case, step or case.step
        self.settings = settings or BEST[case.name]
        self.counts = None  # (steps, Newton iterations, Jacobians) of the last run

    def _build(self):
        container = exu.SystemContainer()
        mbs = container.AddSystem()
        bodies = MODELS[self.settings.model or self.case.model](mbs, self.case.size, self.settings)
        return container, mbs, bodies

    def integrate(self):
        """Solve the whole duration; CPU time [s]."""
        container, mbs, _ = self._build()
        mbs.Assemble()
        return self._solve(mbs)

    def trace(self):
        """The probes (n_samples, n_probes) at every ``case.every`` steps of the case, the start left out."""
        container, mbs, bodies = self._build()
        sensors = [self._sensor(mbs, bodies, probe) for probe in self.case.probes]
        mbs.Assemble()
        self._solve(mbs)
        columns = [
            mbs.GetSensorStoredData(sensor)[1:, 1 + probe.axis]
            for sensor, probe in zip(sensors, self.case.probes, strict=True)
        ]
        return np.column_stack(columns)

    def save(self, path, interval):
        """Solve the whole duration, and write the solution to a file at every ``interval`` [s]."""
        container, mbs, _ = self._build()
        mbs.Assemble()
        given = self._simulation()
        given.solution.file.write = True
        given.solution.file.name = str(path)
        given.solution.file.writePeriod = interval
        if not mbs.SolveDynamic(given, showHints=False):
            raise RuntimeError(f"Exudyn does not solve {self.case.name}")

    def _sensor(self, mbs, bodies, probe):
        kind = exu.OutputVariableType
        what = kind.Position if probe.what == "position" else kind.AngularVelocity
        return mbs.AddSensor(
            lib.SensorBody(
                bodyNumber=bodies[probe.body], localPosition=[probe.point, 0, 0], storeInternal=True,
                outputVariableType=what,
            )
        )  # fmt: skip

    def _solve(self, mbs):
        given = self._simulation()
        done, start = False, time.process_time()
        with contextlib.suppress(ValueError):
            done = mbs.SolveDynamic(given, showHints=False)
        spent = time.process_time() - start
        if not done:
            raise RuntimeError(f"Exudyn does not solve {self.case.name} with {self.settings}")
        solver = mbs.sys["dynamicSolver"]
        steps = round(self.case.duration / self.step)
        self.counts = steps, int(solver.it.newtonStepsCount), int(solver.it.newtonJacobiCount)
        return spent

    def _simulation(self):
        want, given = self.settings, exu.SimulationSettings()
        integration = given.timeIntegration
        integration.numberOfSteps = round(self.case.duration / self.step)
        integration.endTime = self.case.duration
        integration.adaptiveStep = False
        integration.generalizedAlpha.spectralRadius = want.rho
        integration.generalizedAlpha.useIndex2Constraints = want.method != "index 3"
        integration.generalizedAlpha.useNewmark = want.method == "trapezoidal"
        integration.newton.useModifiedNewton = want.modified
        integration.newton.relativeTolerance = want.relative
        integration.newton.absoluteTolerance = want.absolute
        given.linearSolver.solverType = SOLVERS[want.solver]
        given.linearSolver.reuseAnalyzedPattern = True
        given.linearSolver.ignoreSingularJacobian = want.redundant
        given.solution.file.write = False
        given.solution.sensors.writePeriod = self.case.step * self.case.every
        given.parallel.numberOfThreads = 1
        return given


if __name__ == "__main__":  # the script of a user: CASE FILE
    from cases import CASES

    case = CASES[sys.argv[1]]
    Exudyn(case).save(sys.argv[2], case.every * case.step)
