"""Write the deck of a deployable reflector: triangular cells of longerons, folding battens and wound diagonals.

    python inputs/make_reflector.py > reflector.yaml
    python inputs/make_reflector.py --modules 7 --height 1.5 --batten 0.8 --curvature 20 > seven.yaml

After section 4.1 of Cardona, Geradin & Doan, Comput. Methods Appl. Mech. Engrg. 89 (1991) 395-418. A module is a
hexagon of six triangular cells; modules lie side by side, from the middle outwards, and share longerons and faces
where they meet. All longerons stand on a triangular lattice and stay parallel to z. A face between two longerons has
a batten below and one above, each of two halves with a hinge in the middle, and two diagonals with a winder each. The
hinge axes are normal to the face. The spokes of the modules have motors in the middle of their battens; the other
battens follow. All lock when they are straight.

Deployed, each longeron is raised by r^2/(2 R), r its distance from the axis, which makes the faces parallelograms;
the full lengths of their diagonals, which differ, hold them so. Folded, all is nearer to the axis and lower by the
same factor.
"""

import argparse
import math
import sys
from collections.abc import Iterable, Iterator, Sequence

DIRECTIONS = ((1, 0), (0, 1), (-1, 1), (-1, 0), (0, -1), (1, -1))  # to the neighbours on the triangular lattice
LEVELS = ("low", "high")
MOTOR = (  # angle that is left to the motor [rad], torque [N m]
    (0.0, 0.0), (0.05, 0.068), (0.12, 0.09), (0.25, 0.057), (0.5, 0.034), (1.0, 0.027), (3.2, 0.034),
)  # fmt: skip


def options(arguments: Sequence[str] | None = None) -> argparse.Namespace:
    """Parsed arguments of the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add = parser.add_argument
    add("--modules", type=int, default=1, help="their number; 1, 7, 19, 37 ... fill a hexagon [%(default)s]")
    add("--height", type=float, default=1.2, help="length of the longerons [%(default)s m]")
    add("--batten", type=float, default=1.0, help="distance of the longerons, deployed [%(default)s m]")
    add("--curvature", type=float, default=10.0, help="radius R of the reflector [%(default)s m]")
    add("--fold", type=float, default=80.0, help="tilt of the halves of a folded batten [%(default)s degrees]")
    add("--pretension", type=float, default=5e-4, help="strain of the diagonals, deployed [%(default)s]")
    add("--torque", type=float, default=1.0, help="factor of the torque of the motors [%(default)s]")
    add("--end", type=float, default=4.0, help="end of the run [%(default)s s]")
    add("--step", type=float, default=0.01, help="time step [%(default)s s]")
    add("--free", action="store_true", help="floats freely; else the foot of the middle longeron is clamped")
    given = parser.parse_args(arguments)
    if given.modules < 1 or given.curvature == 0.0 or not 0.0 < given.fold < 90.0:
        parser.error("--modules must be 1 or more, --curvature not zero, --fold between 0 and 90")
    if min(given.height, given.batten, given.torque, given.end, given.step) <= 0.0:
        parser.error("--height, --batten, --torque, --end and --step must be greater than zero")
    return given


class Reflector:
    """Lattice points (i, j) of the longerons, in the order of their numbers, and faces between them.

    ``faces`` are (first, second, True for a spoke), with the numbers of longerons.
    """

    def __init__(self, given: argparse.Namespace):
        self.given = given
        points: dict[tuple[int, int], int] = {}  # numbers of the longerons by their places
        edges: dict[frozenset, tuple] = {}  # faces by the places at their ends
        for centre in middles(given.modules):
            corners = [(centre[0] + i, centre[1] + j) for i, j in DIRECTIONS]
            for point in (centre, *corners):
                points.setdefault(point, len(points))
            for corner, following in zip(corners, corners[1:] + corners[:1], strict=True):
                edges[frozenset((centre, corner))] = centre, corner, True
                edges.setdefault(frozenset((corner, following)), (corner, following, False))
        self.points = list(points)
        self.faces = [(points[a], points[b], spoke) for a, b, spoke in edges.values()]
        self.folded = math.cos(math.radians(given.fold))

    def place(self, number: int) -> tuple[float, float]:
        """x and y of a longeron, deployed [m]."""
        i, j = self.points[number]
        return self.given.batten * (i + 0.5 * j), self.given.batten * math.sqrt(0.75) * j

    def rise(self, number: int) -> float:
        """Height of a longeron, deployed [m]."""
        x, y = self.place(number)
        return (x * x + y * y) / (2.0 * self.given.curvature)

    def knee(self, a: int, b: int, z: float, side: float) -> tuple[float, float, float]:
        """Place of the knee of a folded batten at the height z, above (side 1) or below (-1) its ends [m]."""
        (xa, ya), (xb, yb) = self.place(a), self.place(b)
        raised, height = self.rise(b) - self.rise(a), 0.5 * math.sin(math.radians(self.given.fold)) * side
        along = [0.5 * self.folded * (first + second) for first, second in ((xa, xb), (ya, yb))]
        out = [-height * raised * (second - first) / self.given.batten for first, second in ((xa, xb), (ya, yb))]
        middle = z + 0.5 * self.folded * (self.rise(a) + self.rise(b)) + height * self.given.batten
        return along[0] + out[0], along[1] + out[1], middle

    def diagonals(self, a: int, b: int) -> Iterator[tuple[str, str, float]]:
        """(level at a, level at b, full length [m]) of the two diagonals of a face."""
        raised, width = self.rise(b) - self.rise(a), self.given.batten
        for at_a, at_b, height in (("low", "high", self.given.height), ("high", "low", -self.given.height)):
            yield at_a, at_b, math.hypot(width, height + raised) / (1.0 + self.given.pretension)


def middles(count: int) -> list[tuple[int, int]]:
    """Lattice points of the middles of modules, ring by ring, each counterclockwise."""
    reach = 1 + math.isqrt(count)
    own = [(i, j) for i in range(-reach, reach + 1) for j in range(-reach, reach + 1)]
    turn = {(i, j): math.atan2(math.sqrt(0.75) * j, i + 0.5 * j) % math.tau for i, j in own}
    own.sort(key=lambda at: (max(abs(at[0]), abs(at[1]), abs(sum(at))), round(turn[at], 9)))
    return [(i - j, i + 2 * j) for i, j in own[:count]]


def text(numbers: Iterable[float]) -> str:
    """A list in YAML."""
    return "[" + ", ".join(f"{x + 0.0:.15g}" for x in numbers) + "]"


def nodes(of: Reflector) -> Iterator[str]:
    """Lines of the section nodes."""
    scale, height = of.folded, of.given.height
    level = dict(zip(LEVELS, (0.0, height), strict=True))
    for number in range(len(of.points)):
        x, y, rise = (scale * c for c in (*of.place(number), of.rise(number)))
        for name in LEVELS:
            held = ", fixed: true" if (number, name) == (0, "low") and not of.given.free else ""
            yield f"  post{number}_{name}: {{position: {text((x, y, rise + level[name]))}{held}}}"
    for a, b, _ in of.faces:
        (xa, ya, za), (xb, yb, zb) = ([scale * c for c in (*of.place(n), of.rise(n))] for n in (a, b))
        for name in LEVELS:
            z = level[name]
            middle = of.knee(a, b, z, 1.0 if name == "low" else -1.0)
            ends = ("a", xa, ya, z + za), ("m", *middle), ("n", *middle), ("b", xb, yb, z + zb)
            for end, *position in ends:
                yield f"  {face(a, b)}_{name}_{end}: {{position: {text(position)}}}"


def face(a: int, b: int) -> str:
    """Name of a face."""
    return f"face{a}_{b}"


def elements(of: Reflector) -> Iterator[str]:
    """Lines of the section elements."""
    for number in range(len(of.points)):
        yield f"  post{number}: {{type: beam, nodes: [post{number}_low, post{number}_high], section: post, mesh: 4}}"
        for name in LEVELS:
            yield f"  fitting{number}_{name}: {{type: point_mass, node: post{number}_{name}, mass: $fitting}}"
    for a, b, _ in of.faces:
        for name in LEVELS:
            batten = f"{face(a, b)}_{name}"
            for half, ends in (("first", "a m"), ("second", "n b")):
                first, second = ends.split()
                ends = f"{batten}_{first}, {batten}_{second}"
                yield f"  {batten}_{half}: {{type: beam, nodes: [{ends}], section: batten}}"
            yield f"  {batten}_knee: {{type: point_mass, node: {batten}_m, mass: $knee}}"
    for a, b, _ in of.faces:
        for at_a, at_b, length in of.diagonals(a, b):
            sign = "rising" if at_a == "low" else "falling"
            ends = f"post{a}_{at_a}, post{b}_{at_b}"
            yield (
                f"  {face(a, b)}_{sign}: {{type: cable, nodes: [{ends}], E: $cable_modulus, "
                f"area: $cable_area, natural_length: {length:.15g}, payout_tension: $payout_tension, "
                "at_full_length: shock}"
            )


def joints(of: Reflector) -> Iterator[str]:
    """Lines of the section joints."""
    for a, b, spoke in of.faces:
        (xa, ya), (xb, yb) = of.place(a), of.place(b)
        opened = 2.0 * math.radians(of.given.fold)
        for name in LEVELS:
            sign = (1.0 if name == "low" else -1.0) / of.given.batten
            axis = text((sign * (yb - ya), sign * (xa - xb), 0.0))
            batten = f"{face(a, b)}_{name}"
            yield f"  {batten}_at_{a}: {{type: hinge, nodes: [post{a}_{name}, {batten}_a], axis: {axis}}}"
            motor = f", turning_law: motor, natural_angle: {opened:.15g}" if spoke else ""
            latch = f"latch: {{angle: {opened:.15g}}}"
            yield f"  {batten}: {{type: hinge, nodes: [{batten}_m, {batten}_n], axis: {axis}{motor}, {latch}}}"
            yield f"  {batten}_at_{b}: {{type: hinge, nodes: [post{b}_{name}, {batten}_b], axis: {axis}}}"


TIME = "{{end: {:g}, step: {:g}, rho_inf: 0.0}}"
HEADER = """\
# Deployable reflector: {modules} module(s) of six triangular cells, written by
# inputs/make_reflector.py {arguments}
#
# After section 4.1 of Cardona, Geradin & Doan, Comput. Methods Appl. Mech. Engrg. 89 (1991) 395-418, which prints, for
# one module: 756 degrees of freedom, 12 motor hinges, 24 diagonals with winders, fully deployed at t = 3.65 s, 210
# steps. Dimensions, masses and the torque of the motors are chosen here: see docs/examples/reflector.md.
# One module has 756 unknowns and locks its last hinge at t = 3.67 s.
"""


def deck(given: argparse.Namespace, arguments: Sequence[str] = ()) -> str:
    """The deck as text."""
    of = Reflector(given)
    points = [(-angle, -given.torque * torque) for angle, torque in reversed(MOTOR[1:])]
    points += [(angle, given.torque * torque) for angle, torque in MOTOR]
    lines = [
        HEADER.format(modules=given.modules, arguments=" ".join(arguments)).replace(" \n", "\n").rstrip("\n"),
        "mecano: 1",
        "title: Deployable reflector",
        "gravity: none",
        "",
        "parameters:",
        "  cable_modulus: 1.0e+10 # Pa, braided cord of 1 mm2",
        "  cable_area: 1.0e-6",
        "  payout_tension: 0.02 # N, of the winders",
        "  fitting: 0.1 # kg, at both ends of each longeron",
        "  knee: 0.05 # kg, in the middle of each batten",
        "",
        "laws:",
        "  motor: {table: {points: [" + ", ".join(f"[{x:.10g}, {y:.10g}]" for x, y in points) + "]}}",
        "",
        "sections:",
        "  post: {type: tube, diameter: 0.04, thickness: 0.001, E: 7.0e+10, nu: 0.3, density: 1600, damping: 0.0}",
        "  batten: {type: tube, diameter: 0.02, thickness: 0.001, E: 7.0e+10, nu: 0.3, density: 1600, damping: 0.0}",
        "",
        "nodes:", *nodes(of), "", "elements:", *elements(of), "", "joints:", *joints(of), "",
        "time: " + TIME.format(given.end, given.step),
    ]  # fmt: skip
    return "\n".join(lines) + "\n"


def main() -> None:
    """Write the deck to the standard output."""
    sys.stdout.write(deck(options(), sys.argv[1:]))


if __name__ == "__main__":
    main()
