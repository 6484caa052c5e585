"""A digital controller holds a hinged bar: time per sample and error of the angle, here and in Exudyn.

Exudyn computes the moment in a function of Python before each step, as its users do; mecano samples a signal. The error
is the largest of the angle at the samples of the first second, against SciPy from sample to sample.
"""

import math
import time

import numpy as np
from cases import GRAVITY, LENGTH, MASS
from exudyn_side import _bar, _hinge, exu, lib
from scipy.integrate import solve_ivp

import mecano

PERIOD, SAMPLES, JUDGED = 1e-3, 5000, 1000
STIFFNESS, DAMPING, WANTED = 60.0, 8.0, 0.5  # N m/rad, N m s/rad, rad
BAR = _bar().inertiaTensor.diagonal()
ABOUT_HINGE = BAR[1] + MASS * (0.5 * LENGTH) ** 2
WEIGHT = 0.5 * MASS * GRAVITY * LENGTH  # moment of the horizontal bar [N m]


def exact():
    """Angles [rad] at the samples."""
    y, angles = np.zeros(2), []
    for _ in range(JUDGED):
        moment = STIFFNESS * (WANTED - y[0]) - DAMPING * y[1]
        rates = lambda t, y, moment=moment: [y[1], (moment + WEIGHT * math.cos(y[0])) / ABOUT_HINGE]  # noqa: E731
        y = solve_ivp(rates, (0.0, PERIOD), y, rtol=1e-12, atol=1e-13).y[:, -1]
        angles.append(y[0])
    return np.array(angles)


def in_mecano(steps):
    """CPU time of a sample [s] and angles, with so many steps between two samples."""
    model = mecano.Deck(
        {
            "mecano": 1,
            "gravity": [0, 0, -GRAVITY],
            "nodes": {"pin": {"position": [0, 0, 0]}},
            "elements": {
                "bar": {
                    "type": "rigid_body", "node": "pin", "mass": MASS, "center_of_mass": [0.5 * LENGTH, 0, 0],
                    "inertia": BAR.tolist(),
                }
            },
            "joints": {"hinge": {"type": "hinge", "nodes": ["ground", "pin"], "axis": [0, 1, 0]}},
            "signals": {
                "moment": {
                    "type": "sample_and_hold", "period": PERIOD,
                    "input": f"{STIFFNESS}*({WANTED} - hinge.angle) - {DAMPING}*hinge.rate",
                }
            },
            "loads": {"motor": {"type": "joint_moment", "joint": "hinge", "value": "moment"}},
            "time": {"end": SAMPLES * PERIOD, "step": PERIOD / steps},
            "output": {"every": PERIOD},
        }
    )  # fmt: skip
    with mecano.Simulation(model, "sampled.h5", force=True) as run:
        run.advance(PERIOD)
        began = time.process_time()
        run.advance((SAMPLES - 1) * PERIOD)
        spent = time.process_time() - began
    with run.results() as results:
        return spent / SAMPLES, results["hinge.angle"].values[1 : JUDGED + 1]


def in_exudyn(steps):
    """CPU time of a sample [s] and angles, with so many steps between two samples."""
    system, angles, made = exu.SystemContainer().AddSystem(), [], []
    ground = system.CreateGround()
    bar = system.CreateRigidBody(
        referencePosition=[0.5 * LENGTH, 0, 0], inertia=_bar(), gravity=[0, 0, -GRAVITY],
        nodeType=exu.NodeType.RotationEulerParameters,
    )  # fmt: skip
    _hinge(system, [ground, bar], [0, 0, 0], [0, 1, 0])
    marker = system.AddMarker(lib.MarkerBodyRigid(bodyNumber=bar))
    motor = system.AddLoad(lib.LoadTorqueVector(markerNumber=marker, loadVector=[0, 0, 0]))
    kinds = exu.OutputVariableType.Rotation, exu.OutputVariableType.AngularVelocity
    angle, rate = (
        system.AddSensor(lib.SensorBody(bodyNumber=bar, outputVariableType=kind, writeToFile=False)) for kind in kinds
    )

    def sample(system, t):
        if len(made) % steps == 0:
            angles.append(system.GetSensorValues(angle)[1])
            moment = STIFFNESS * (WANTED - angles[-1]) - DAMPING * system.GetSensorValues(rate)[1]
            system.SetLoadParameter(motor, "loadVector", [0, moment, 0])
        made.append(t)
        return True

    system.SetPreStepUserFunction(sample)
    system.Assemble()
    settings = exu.SimulationSettings()
    settings.timeIntegration.numberOfSteps = SAMPLES * steps
    settings.timeIntegration.endTime = SAMPLES * PERIOD
    settings.timeIntegration.newton.relativeTolerance = 1e-5
    settings.timeIntegration.generalizedAlpha.useIndex2Constraints = True
    settings.timeIntegration.generalizedAlpha.useNewmark = True
    settings.solution.file.write = False
    settings.timeIntegration.verboseMode = 0
    began = time.process_time()
    system.SolveDynamic(settings)
    return (time.process_time() - began) / SAMPLES, np.array(angles[1 : JUDGED + 1])


def main():
    """Print the table of docs/benchmarks.md."""
    expected = exact()
    for name, function in (("mecano", in_mecano), ("Exudyn", in_exudyn)):
        for steps in (1, 2, 4):
            found = [function(steps) for _ in range(5)]
            error = np.abs(found[0][1] - expected).max()
            print(f"| {name} | {steps} | {1e6 * min(spent for spent, _ in found):.1f} | {error:.1e} |")


if __name__ == "__main__":
    main()
