"""A swinging block and tackle in mecano and in Exudyn's ReevingSystemSprings: ``python tests/benchmarks/reeving.py``.

A rope runs from an anchor down to a sheave on a block of 100 kg, up over a fixed sheave and down to a counterweight of
45 kg. The block is struck sideways, so that wrap angles and falls change. Both codes model a massless elastic rope
without friction; their positions are compared after two seconds, for steps that are halved.
"""

import numpy as np
from exudyn_side import exu

END, EA, BLOCK, WEIGHT, G, TENSION = 2.0, 1.0e5, 100.0, 45.0, 9.81, 450.0
PLACES = {"anchor": (-0.2, 0.0, 0.0), "block": (0.0, 0.0, -4.0), "head": (0.35, 0.0, 0.0), "weight": (0.5, 0.0, -3.0)}
RADII = (0.0, 0.2, 0.15, 0.0)
SPEED = 1.5  # m/s of the block along x

DECK = f"""
mecano: 1
gravity: [0, 0, -{G}]
nodes:
  anchor: {{position: {list(PLACES["anchor"])}, fixed: true}}
  block: {{position: {list(PLACES["block"])}}}
  head: {{position: {list(PLACES["head"])}, fixed: true}}
  weight: {{position: {list(PLACES["weight"])}}}
elements:
  block: {{type: rigid_body, node: block, mass: {BLOCK}, inertia: [2, 2, 2]}}
  weight: {{type: rigid_body, node: weight, mass: {WEIGHT}, inertia: [1, 1, 1]}}
  rope: {{type: reeved_cable, nodes: [anchor, block, head, weight], radii: [0, 0.2, -0.15, 0], axis: [0, -1, 0],
    axial_stiffness: {EA}, pretension: {TENSION}}}
initial: {{velocities: [{{nodes: [block], velocity: [{SPEED}, 0, 0]}}]}}
time: {{end: {END}, step: STEP, rho_inf: 1.0}}
"""


def in_mecano(step):
    """Positions of block and weight at the end, and the length of the rope at the start."""
    from time_runs import RecordedRun, deck

    m = RecordedRun(deck(DECK.replace("STEP", str(step))))
    ends = [m[f"nodes/{name}/position"][-1] for name in ("block", "weight")]
    return np.array(ends), m["elements/rope/length"][0]


def in_exudyn(step, length):
    """The same positions; ``length`` [m] of the rope at the start."""
    import exudyn.itemInterface as items
    from exudyn.rigidBodyUtilities import RigidBodyInertia

    container = exu.SystemContainer()
    mbs = container.AddSystem()
    ground = mbs.AddObject(items.ObjectGround())
    markers, nodes = [], {}
    for name, mass in (("anchor", 0), ("block", BLOCK), ("head", 0), ("weight", WEIGHT)):
        if not mass:
            markers.append(mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=ground, localPosition=PLACES[name])))
            continue
        inertia = RigidBodyInertia(mass=mass, inertiaTensor=np.eye(3) * (2 if name == "block" else 1))
        speed = [SPEED, 0, 0] if name == "block" else [0, 0, 0]
        made = mbs.CreateRigidBody(inertia=inertia, referencePosition=PLACES[name], initialVelocity=speed,
                                   gravity=[0, 0, -G], returnDict=True)  # fmt: skip
        nodes[name] = made["nodeNumber"]
        markers.append(mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=made["bodyNumber"])))
    mbs.AddObject(items.ReevingSystemSprings(
        markerNumbers=markers, hasCoordinateMarkers=False, stiffnessPerLength=EA, dampingPerLength=0.0,
        referenceLength=length / (1.0 + TENSION / EA), regularizationForce=-1.0,
        sheavesAxes=exu.Vector3DList([[0, -1, 0], [0, -1, 0], [0, 1, 0], [0, -1, 0]]),
        sheavesRadii=list(RADII),
    ))  # fmt: skip
    mbs.Assemble()
    settings = exu.SimulationSettings()
    settings.timeIntegration.numberOfSteps, settings.timeIntegration.endTime = round(END / step), END
    settings.timeIntegration.generalizedAlpha.spectralRadius = 1.0
    settings.timeIntegration.verboseMode = 0
    settings.solution.file.write = False
    newton = settings.timeIntegration.newton
    newton.relativeTolerance, newton.absoluteTolerance = 1e-10, 1e-10
    mbs.SolveDynamic(settings, solverType=exu.DynamicSolverType.GeneralizedAlpha)
    position = exu.OutputVariableType.Position
    return np.array([mbs.GetNodeOutput(nodes[name], position) for name in ("block", "weight")])


def main():
    """Print both positions and their largest difference."""
    for step in (2e-3, 1e-3, 5e-4):
        ours, length = in_mecano(step)
        theirs = in_exudyn(step, length)
        shown = np.array2string(ours, precision=7).replace("\n", "")
        print(f"{step:g} s: {shown}, difference {np.abs(ours - theirs).max():.2e} m")


if __name__ == "__main__":
    main()
