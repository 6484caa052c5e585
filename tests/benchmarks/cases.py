"""The benchmark cases: the numbers that both codes build their models from, and what is compared.

mecano has one model of a four-bar, with hinges in space everywhere, which are redundant. Exudyn solves it with the same
hinges only by a dense solver with full pivoting; beside it stand its isostatic models, in space and in the plane.

A *probe* is a number of the motion, the same in both codes: a coordinate of a point of a body, or the rate at which a
body turns about the inertial y axis. Errors of probes are relative to ``scale``.
"""

from dataclasses import dataclass

LENGTH, THICKNESS, MASS, GRAVITY = 1.0, 0.05, 1.0, 9.81  # of the bars of chains and four-bars [m, kg, m/s2]
TOP_SPEED = 1.0  # of the four-bar at the start [m/s]


@dataclass(frozen=True)
class Gear:
    """A landing gear that drops on a runway: top mass, strut, slider and wheel with a linear tyre."""

    top_mass: float = 6440.0  # [kg]
    top_inertia: float = 5000.0  # [kg m2]
    slider_mass: float = 150.0
    slider_inertia: tuple = (5.0, 5.0, 2.0)
    wheel_mass: float = 60.0
    wheel_inertia: tuple = (1.8, 3.0, 1.8)
    radius: float = 0.3225  # [m]
    clearance: float = 0.01  # under the wheel at the start [m]
    strut: float = 1.5  # natural length [m]
    stiffness: float = 1.2e5  # of the strut [N/m]
    damping: float = 4.0e4  # [N s/m]
    tyre: float = 1.2e6  # radial stiffness [N/m]
    friction: float = 0.6
    slip: float = 0.5  # slip speed below which the friction falls to zero [m/s]
    speed: float = 60.0  # forward, at the start [m/s]
    sink: float = 3.05  # [m/s]


GEAR = Gear()


@dataclass(frozen=True)
class Disc:
    """A disc that rolls on a plane without slip, leaning."""

    radius: float = 0.1  # [m]
    mass: float = 0.5  # [kg]
    lean: float = 0.2  # [rad]
    spin: float = 20.0  # about its axis [rad/s]
    turning: float = 1.5  # about the vertical [rad/s]

    @property
    def inertia(self):
        """Moments of inertia [kg m2]; the axis is the second one."""
        across = 0.25 * self.mass * self.radius**2
        return [across, 2.0 * across, across]


DISC = Disc()


@dataclass(frozen=True)
class Probe:
    """A number of the motion: of the body at ``body`` in the order of both models."""

    what: str  # "position" or "turning"
    body: int
    axis: int = 1
    point: float = 0.0  # along the bar, from its centre [m]
    scale: float = 1.0


@dataclass(frozen=True)
class Case:
    """A model, its steps, and the bound on mecano/Exudyn that the project sets itself."""

    name: str
    words: str
    model: str  # function of mecano_side and, unless ``BEST`` has another, of exudyn_side
    size: int
    step: float  # [s]
    steps: int
    required: float
    probes: tuple
    rho: float = 0.9  # of mecano; that of Exudyn stands in exudyn_side.BEST
    every: int = 20  # steps between two samples of the probes
    finer: int = 8  # steps of the reference are so much shorter, and half of that
    same_physics: bool = True  # both codes converge to one motion
    errors: tuple = ()  # that both codes are to reach, each with the longest steps that do

    @property
    def duration(self):
        """Simulated time [s]."""
        return self.steps * self.step


def _tips(n):
    """The ends of the first ten links of a chain and of the last one: x and z."""
    links = sorted({*range(min(n, 10)), n - 1})
    return tuple(Probe("position", i, axis, 0.5 * LENGTH, LENGTH) for i in links for axis in (0, 2))


def _corners(n):
    """The upper ends of all cranks of a four-bar: x and y."""
    return tuple(Probe("position", i, axis, 0.5 * LENGTH, LENGTH) for i in range(n + 1) for axis in (0, 1))


TOP, SLIDER, WHEEL = range(3)
_GEAR_PROBES = (
    Probe("position", TOP, 0, scale=1.0),
    Probe("position", TOP, 2, scale=1.0),
    Probe("position", WHEEL, 2, scale=GEAR.radius),
    Probe("turning", WHEEL, scale=GEAR.speed / GEAR.radius),
)

_DISC_PROBES = tuple(Probe("position", 0, axis, scale=DISC.radius) for axis in range(3))

CASES = {
    case.name: case
    for case in (
        Case("chain-1", "one hinged bar", "chain", 1, 1e-3, 2000, 0.5, _tips(1)),
        Case("chain-10", "ten bars", "chain", 10, 1e-3, 1000, 0.4, _tips(10)),
        Case("chain-100", "a hundred bars", "chain", 100, 1e-3, 1000, 0.35, _tips(100), finer=4),
        Case("chain-1000", "a thousand bars", "chain", 1000, 1e-3, 300, 0.25, _tips(1000), finer=4),
        Case("four-bar-1-planar", "Exudyn in the plane", "four_bar", 1, 1e-3, 1000, 1.0, _corners(1), rho=0.95),
        Case(
            "four-bar-1-spatial",
            "Exudyn with isostatic joints in space",
            "four_bar",
            1,
            1e-3,
            1000,
            0.4,
            _corners(1),
            rho=0.95,
        ),
        Case("four-bar-10-planar", "Exudyn in the plane", "four_bar", 10, 1e-3, 500, 0.7, _corners(10), rho=0.95),
        Case(
            "four-bar-10-spatial",
            "Exudyn with isostatic joints in space",
            "four_bar",
            10,
            1e-3,
            500,
            0.3,
            _corners(10),
            rho=0.95,
        ),
        Case("four-bar-10", "redundant hinges everywhere", "four_bar", 10, 1e-3, 500, 0.12, _corners(10), rho=0.95),
        Case("rolling-disc", "a disc that rolls without slip", "rolling_disc", 1, 1e-3, 2000, 1.0, _DISC_PROBES),
        Case(
            "gear-drop",
            "a landing gear with a friction tyre",
            "gear_drop",
            1,
            1e-3,
            3000,
            0.5,
            _GEAR_PROBES,
            rho=0.8,
            same_physics=False,
            errors=(1e-3, 1e-4, 1e-5),
        ),
    )
}
