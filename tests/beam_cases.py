"""Exact solutions for beams at rest, each with a function that returns the error with n elements.

Numbers of reference/e1 of the project's collection: exact Reissner-Simo rods by shooting, residuals below 1e-10.
"""

import numpy as np
from equilibria import Equilibrium
from scipy.linalg import eigvalsh
from scipy.optimize import brentq

LEAST = (
    "EA: {EA}, GA2: {GA}, GA3: {GA}, GJ: {GJ}, EI2: {EI2}, EI3: {EI3}, mass_per_length: 1, rotary_inertia: [2, 1, 1]"
)

ELASTICA = {  # P L^2/EI: angle [rad], deflection/L, shortening/L of an inextensible cantilever under a dead tip force
    1.0: (0.4613519497118786, 0.30172077379981355, 0.056433236283377264),
    4.0: (1.1212393474875761, 0.6699641812776667, 0.32894124224684596),
    10.0: (1.4302855388038587, 0.8106090248802966, 0.5549955977537513),
}
BEND = {  # tip of the 45 degree bend, R = 100, EA = 1e7, GA = 5e6, EI = GJ = 1e7/12, dead force across its plane
    300.0: (22.24478094536791, 58.779122489683395, 40.191891670149815),
    600.0: (15.684800534039004, 47.15043857362944, 53.47485879182518),
}
PRINCETON = {  # 8.896 N at an angle [deg] from the height of the section: flapwise, edgewise displacement, shortening
    0: (0.0, 0.01071531427764692, 0.0001355782180204601),
    15: (0.04212502452222174, 0.010625626804972942, 0.002240812714878415),
    30: (0.07945579698221386, 0.010147003767340172, 0.007660756273497826),
    45: (0.10904131677603779, 0.008888564440882716, 0.01438924698727001),
    60: (0.12992333902480285, 0.006654096119399095, 0.020473126258912844),
    75: (0.14221431051674369, 0.00356873456484159, 0.024583862440217763),
    90: (0.14625990368034736, 0.0, 0.026024205484200036),
}
FLAP, EDGE = 2.428734443353508, 36.27936354403289  # bending stiffnesses of the Princeton beam [N m2]
BUCKLING = 4.012599343578901  # P L^2/sqrt(EI_min GJ), lateral buckling of a cantilever; J_{-1/4}(P/2) = 0


def straight(section, length, n, loads, more=""):
    """Deck of a cantilever along x, clamped at the origin."""
    return f"""
        mecano: 1
        gravity: [0, 0, 0]
        sections: {{rod: {section}}}
        nodes: {{root: {{position: [0, 0, 0], fixed: true}}, tip: {{position: [{length}, 0, 0]}}}}
        elements: {{leg: {{type: beam, nodes: [root, tip], section: rod, up: [0, 0, 1], mesh: {n}{more}}}}}
        loads: {{{loads}}}
        static: {{}}
    """


def stiffness(**values):
    """Section of given stiffnesses."""
    return f"{{type: stiffness, {LEAST.format(**values)}}}"


def dead_force(x, y, z):
    """Force (x, y, z) at the tip."""
    size = float(np.linalg.norm([x, y, z]))
    return f"pull: {{type: force, node: tip, direction: [{x}, {y}, {z}], value: {size}}}"


def relative(found, expected, size=None):
    """Length of the error over that of the answer."""
    expected = np.asarray(expected)
    return float(np.linalg.norm(found - expected) / (size or np.linalg.norm(expected)))


def roll_up(n):
    """Distance of the tip of a rod bent to a full circle from its root, over its length."""
    section = stiffness(EA=1e4, GA=5e3, GJ=100.0, EI2=100.0, EI3=100.0)
    size = 2.0 * np.pi * 100.0 / 10.0
    load = f"turn: {{type: moment, node: tip, direction: [0, -1, 0], value: {size}}}"
    return float(np.linalg.norm(Equilibrium(straight(section, 10.0, n, load)).position("tip")) / 10.0)


def elastica(n, load):
    """Error of the tip displacement; extensible by 1e-8 of the bending."""
    section = stiffness(EA=1e8, GA=1e8, GJ=1.0, EI2=1.0, EI3=1.0)
    found = Equilibrium(straight(section, 1.0, n, dead_force(0, 0, load)))
    x, _, z = found.position("tip")
    _, deflection, shortening = ELASTICA[load]
    return relative([z, 1.0 - x], [deflection, shortening])


def bend(n, load):
    """Error of the tip displacement of the 45 degree bend."""
    tip, via = (
        100.0 * np.array([1 - np.sqrt(0.5), np.sqrt(0.5), 0]),
        100.0 * np.array([1 - np.cos(np.pi / 8), np.sin(np.pi / 8), 0]),
    )
    text = straight(stiffness(EA=1e7, GA=5e6, GJ=1e7 / 12, EI2=1e7 / 12, EI3=1e7 / 12), 1.0, n, dead_force(0, 0, load))
    text = text.replace("[1.0, 0, 0]", str(tip.tolist())).replace(
        "up: [0, 0, 1]", f"up: [0, 0, 1], via: {via.tolist()}"
    )
    return relative(Equilibrium(text).position("tip") - tip, BEND[load] - tip)


def princeton(n, degrees):
    """Error of the tip displacement of the Princeton beam: axis 3 along its height."""
    section = stiffness(EA=2841908.71416, GA=922098.8689682027, GJ=3.103796359580112, EI2=EDGE, EI3=FLAP)
    angle = np.radians(degrees)
    load = dead_force(0, 8.896 * np.sin(angle), 8.896 * np.cos(angle))
    found = Equilibrium(straight(section, 0.508, n, load)).position("tip")
    flap, edge, shortening = PRINCETON[degrees]
    return relative(found - [0.508, 0, 0], [-shortening, flap, edge])


def smallest_stiffness(text):
    """Smallest eigenvalue of the tangent at the equilibrium of a deck, reached in one step."""
    K = Equilibrium(text.replace("static: {}", "static: {steps: 1}")).tangent().toarray()
    return eigvalsh(0.5 * (K + K.T), subset_by_index=[0, 0])[0]


def euler_load(n):
    """Relative error of the axial load under which a cantilever buckles, pi^2 EI/(2 L)^2."""
    section, exact = stiffness(EA=1e8, GA=1e8, GJ=1.0, EI2=1.0, EI3=4.0), np.pi**2 / 4

    def smallest(load):
        return smallest_stiffness(straight(section, 1.0, n, dead_force(-load, 0, 0)))

    return brentq(smallest, 0.9 * exact, 1.1 * exact, xtol=1e-7) / exact - 1.0


def lateral_buckling(n):
    """Relative error of the load at which the tangent of a narrow cantilever becomes singular.

    EI_2/EI_3 = 1e5: the finite stiffness counts less than 1e-5, and rounding does not show yet with 64 elements.
    """
    section = stiffness(EA=1e7, GA=1e7, GJ=1.0, EI2=1e5, EI3=1.0)

    def smallest(load):
        return smallest_stiffness(straight(section, 1.0, n, dead_force(0, 0, load)))

    return abs(brentq(smallest, 0.9 * BUCKLING, 1.1 * BUCKLING, xtol=1e-6) / BUCKLING - 1.0)


def torque_buckling(n):
    """Relative error of the torque, 2 x EI/L with tan x = x (Greenhill 1883), that buckles a shaft with clamped ends.

    GJ = 0.8 EI. Its second end turns about the axis of the shaft and slides along it.
    """
    section, exact = stiffness(EA=1e8, GA=1e8, GJ=0.8, EI2=1.0, EI3=1.0), 2.0 * 4.493409457909064

    def smallest(torque):
        load = f"twist: {{type: moment, node: tip, direction: [1, 0, 0], value: {torque}}}"
        found = Equilibrium(straight(section, 1.0, n, load))
        of, tip = found.system.numbering, [node.name for node in found.system.nodes].index("tip")
        held = [of.x[tip] + 1, of.x[tip] + 2, of.r[tip] + 1, of.r[tip] + 2]
        K = np.delete(np.delete(found.tangent().toarray(), held, 0), held, 1)
        return eigvalsh(0.5 * (K + K.T), subset_by_index=[0, 0])[0]

    return brentq(smallest, 0.9 * exact, 1.1 * exact, xtol=1e-6) / exact - 1.0
