"""Structures of textbooks and of NAFEMS, compared with closed forms and published numbers."""

import re

import numpy as np
from equilibria import Equilibrium, Path
from scipy.linalg import expm
from scipy.optimize import brentq
from small_motions import eigenvalues
from time_runs import deck

S = "Structures of textbooks"

MAST = """
    mecano: 1
    gravity: none
    parameters: {E: 200 GPa, I: pi*0.5**4/64, A: pi*0.25**2, rho: 8000}
    sections:
      rod: {type: stiffness, EA: $E*$A, GA2: 1.0e14, GA3: 1.0e14, GJ: $E/1.3*$I, EI2: $E*$I, EI3: $E*$I,
            mass_per_length: $rho*$A, rotary_inertia: [2*$rho*$I, $rho*$I, $rho*$I]}
    nodes:
      root: {position: [0, 0, 0], fixed: true}
      tip: {position: [10, 0, 0]}
      high: {position: [10, 0, 2]}
      low: {position: [10, 0, -2]}
    elements:
      mast: {type: beam, nodes: [root, tip], section: rod, mesh: 10}
      arm_1: {type: rigid_link, nodes: [tip, high]}
      arm_2: {type: rigid_link, nodes: [tip, low]}
      heavy: {type: point_mass, node: high, mass: 10 t}
      light: {type: point_mass, node: low, mass: 1 t}
    time: {end: 1, step: 1 ms}
"""


def frequencies(text, number):
    """Return the lowest frequencies [Hz] of the modes of a deck."""
    values = eigenvalues(deck(text))
    return np.sort(values.imag[values.imag > 1e-3])[:number] / (2 * np.pi)


def test_cantilever_with_masses_off_its_axis(verify):
    """Bending and torsion are coupled."""
    known = [1.723, 1.727, 7.413, 9.972, 18.155, 26.957]
    what, source = "cantilever with off-centre masses: six frequencies [Hz]", "NAFEMS FV4"
    verify(S, what, frequencies(MAST, 6), known, source, relative=3e-4)


CROSS = """
    mecano: 1
    gravity: none
    parameters: {E: 200 GPa, I: 0.125**4/12, A: 0.125**2}
    sections:
      bar: {type: stiffness, EA: $E*$A, GA2: 1.0e14, GA3: 1.0e14, GJ: 1.0e10, EI2: 1.0e3*$E*$I, EI3: $E*$I,
            mass_per_length: 8000*$A, rotary_inertia: [1, 0, 0]}
    nodes:
      hub: {position: [0, 0, 0]}
      end_$i: {repeat: {i: 0..7}, position: [5*cos($i*pi/4), 5*sin($i*pi/4), 0]}
    elements:
      arm_$i: {repeat: {i: 0..7}, type: beam, nodes: [hub, end_$i], section: bar, up: [0, 0, 1], mesh: 4}
    joints:
      plane: {type: planar, nodes: [ground, hub], axis: [0, 0, 1]}
      pin_$i: {repeat: {i: 0..7}, type: hinge, nodes: [ground, end_$i], axis: [0, 0, 1]}
    time: {end: 1, step: 1 ms}
"""


def test_double_cross_with_pinned_ends(verify):
    """Modes in its plane, of arms with Euler's bending; two of each group of seven are lower if arms stretch."""
    known = [11.336, *[17.709] * 7, 45.345, *[57.390] * 7]
    what, source = "pinned double cross: 16 frequencies [Hz]", "NAFEMS FV2"
    verify(S, what, frequencies(CROSS, 16), known, source, relative=6e-3)


FRAME = """
    mecano: 1
    gravity: none
    sections:
      bar: {type: stiffness, EA: 43.2e6, GA2: 1.0e10, GA3: 1.0e10, GJ: 1.0e10, EI2: 14.4e6, EI3: 14.4e10,
            mass_per_length: 0, rotary_inertia: [0, 0, 0]}
    nodes:
      foot: {position: [0, 0, 0]}
      corner: {position: [0, 0, 120]}
      loaded: {position: [24, 0, 120]}
      end: {position: [120, 0, 120]}
    elements:
      column: {type: beam, nodes: [foot, corner], section: bar, up: [1, 0, 0], mesh: 8}
      short: {type: beam, nodes: [corner, loaded], section: bar, up: [0, 0, 1], mesh: 2}
      long: {type: beam, nodes: [loaded, end], section: bar, up: [0, 0, 1], mesh: 8}
    joints:
      pin_1: {type: hinge, nodes: [ground, foot], axis: [0, 1, 0]}
      pin_2: {type: hinge, nodes: [ground, end], axis: [0, 1, 0]}
    loads: {push: {type: force, node: loaded, direction: [0, 0, -1], value: 10 kN}}
    static:
      {method: arc_length, end: 3, steps: 30, until: {node: loaded, direction: [0, 0, -1], displacement: 64}}
"""


def test_lees_frame_snaps(verify):
    """The load rises to 18.552 EI/L^2 and falls, while the loaded point moves back (snap-back)."""
    load = 1e4 * Path(FRAME).factors.max()
    source = "Lee, Manuel & Rossow, J. Engng Mech. Div. ASCE 94, 1968: 18.552 EI/L^2"
    verify(S, "Lee's frame: limit load [N]", load, 18552.0, source, relative=1e-3)


ARCH = """
    mecano: 1
    gravity: none
    parameters: {half: 107.5 deg, quarter: 53.75 deg}
    sections:
      bar: {type: stiffness, EA: 1.0e8, GA2: 1.0e9, GA3: 1.0e9, GJ: 1.0e9, EI2: 1.0e9, EI3: 1.0e6,
            mass_per_length: 0, rotary_inertia: [0, 0, 0]}
    nodes:
      left: {position: [-100*sin($half), 0, 100*cos($half)]}
      top: {position: [0, 0, 100]}
      right: {position: [100*sin($half), 0, 100*cos($half)], fixed: true}
    elements:
      a: {type: beam, nodes: [left, top], section: bar, up: [0, 1, 0], mesh: 16,
          via: [-100*sin($quarter), 0, 100*cos($quarter)]}
      b: {type: beam, nodes: [top, right], section: bar, up: [0, 1, 0], mesh: 16,
          via: [100*sin($quarter), 0, 100*cos($quarter)]}
    joints: {pin: {type: hinge, nodes: [ground, left], axis: [0, 1, 0]}}
    loads: {push: {type: force, node: top, direction: [0, 0, -1], value: 1 kN}}
    static:
      {method: arc_length, end: 1.2, until: {node: top, direction: [0, 0, -1], displacement: 116}}
"""


def test_a_deep_arch_with_one_pinned_end(verify):
    """Its top comes down by more than its radius before it gives way."""
    path = Path(ARCH)
    peak = int(np.argmax(path.factors))
    verify(S, "deep arch, clamped and pinned: limit load [N]", 1e3 * path.factors[peak], 897.0,
           "DaDeppo & Schmidt, J. Appl. Mech. 42, 1975: 8.97 EI/R^2", relative=1e-3)  # fmt: skip
    np.testing.assert_allclose(100 - path.positions("top")[peak, 2], 113.7, atol=1.0)


STRIP = """
    mecano: 1
    gravity: [0, 0, -10]
    sections:
      strip: {type: stiffness, EA: 1.0e7, GA2: 1.0e7, GA3: 1.0e7, GJ: 100, EI2: 50, EI3: 500, mass_per_length: 2,
              rotary_inertia: [1.0e-3, 0, 0]}
    nodes: {far: {position: [0, 0, 0]}, near: {position: [2, 0, 0]}}
    elements:
      strip: {type: beam, nodes: [far, near], section: strip, up: [0, 0, 1], mesh: 40}
      floor_0: {type: contact, nodes: [ground, far], plane: {normal: [0, 0, 1], point: [0, 0, 0]}}
      floor_$i:
        {repeat: {i: 1..39}, type: contact, nodes: [ground, strip.$(i)], plane: {normal: [0, 0, 1], point: [0, 0, 0]}}
    joints:
      plane: {type: generic, nodes: [ground, far], axis: [0, 1, 0], axis_1: [0, 0, 1], free: [along_1, about_axis]}
      lift: {type: prescribed_position, node: near, direction: [0, 0, 1], value: {linear: {slope: 0.05}}}
    static: {over: time, end: 1}
"""


def test_a_strip_is_lifted_off_the_floor_at_its_end(verify):
    """The end is lifted by w l^4/(24 EI) with a force w l/2, where l is the length that has left the floor."""
    found = Equilibrium(STRIP)
    free = sum(found.position(f"strip.{i}")[2] > 1e-6 for i in range(1, 40)) + 1
    exact = (24 * 50 * 0.05 / 20) ** 0.25
    verify(S, "strip lifted off a floor: length in the air [m]", 0.05 * free, exact, "closed form", absolute=0.05)
    force = found.output("joints/lift/force")
    verify(S, "strip lifted off a floor: force at its end [N]", force, 20 * exact / 2, "closed form", relative=1e-3)


HOT = """
    mecano: 1
    gravity: none
    sections:
      rod: {type: stiffness, EA: 1.0e6, GA2: 1.0e7, GA3: 1.0e7, GJ: 1, EI2: 1, EI3: 10, mass_per_length: 1,
            rotary_inertia: [0, 0, 0]}
    nodes: {a: {position: [0, 0, 0], fixed: true}, b: {position: [1, 0, 0], fixed: true}}
    elements: {rod: {type: beam, nodes: [a, b], section: rod, up: [0, 0, 1], mesh: 16, thermal: {strain: 1.0e-5*time}}}
    static: {over: time, end: 10, steps: 20}
"""


def test_a_heated_rod_between_walls_buckles(verify):
    """Loads u^2 EI/L^2: u = 2 pi, symmetric, and tan(u/2) = u/2, antisymmetric; the strain is the load over EA."""
    path = Path(HOT)
    critical = [4 * np.pi**2, 4 * brentq(lambda x: np.tan(x) - x, 4.0, 4.6) ** 2]
    np.testing.assert_array_equal(path.unstable, np.searchsorted(critical, 10 * path.factors))
    found = float(re.search(r"near ([\d.]+), the equilibrium becomes unstable", path.result.warnings[0])[1])
    what = "heated rod between walls: buckles at the strain [1e-6]"
    verify(S, what, 10 * found, critical[0], "closed form", relative=5e-5)


TWISTED = """
    mecano: 1
    gravity: none
    sections:
      blade: {type: stiffness, EA: 1.0e8, GA2: 1.0e8, GA3: 1.0e8, GJ: 1.0e4, EI2: 160, EI3: 10, mass_per_length: 1,
              rotary_inertia: [1.0e-8, 5.0e-9, 5.0e-9]}
    nodes: {root: {position: [0, 0, 0], fixed: true}, tip: {position: [1, 0, 0]}}
    elements: {blade: {type: beam, nodes: [root, tip], section: blade, up: [0, 0, 1], twist: pi/2, mesh: 24}}
    time: {end: 1, step: 1 ms}
"""


def determinant_of_twisted_blade(frequency):
    """Moments and shears at the free tip of TWISTED, by those at its root: zero at a natural frequency [Hz].

    Euler and Bernoulli in axes that turn with the section at k = pi/2 per length, y = (u, phi, M, V), 2 numbers each:
    u' = phi x e, phi' = M/EI, M' = V x e, V' = -w^2 u with the direction e of the blade.
    """
    turn = np.pi / 2 * np.array([[0.0, 1.0], [-1.0, 0.0]])
    across = np.array([[0.0, 1.0], [-1.0, 0.0]])  # a x e
    none = np.zeros((2, 2))
    A = np.block([
        [turn, across, none, none],
        [none, turn, np.diag([1 / 160, 1 / 10]), none],
        [none, none, turn, across],
        [-((2 * np.pi * frequency) ** 2) * np.eye(2), none, none, turn],
    ])  # fmt: skip
    return np.linalg.det(expm(A)[4:, 4:])


def test_a_blade_twisted_by_a_quarter_turn(verify):
    """Flatwise and edgewise bending are coupled."""
    around = np.array([1.82, 5.01, 15.93, 23.97])
    exact = [brentq(determinant_of_twisted_blade, 0.97 * f, 1.03 * f) for f in around]
    what = "twisted blade: four frequencies [Hz]"
    verify(S, what, frequencies(TWISTED, 4), exact, "transfer matrix", relative=1e-5)


PFLUEGER = """
    mecano: 1
    gravity: none
    sections:
      rod: {type: stiffness, EA: 1.0e6, GA2: 1.0e6, GA3: 1.0e6, GJ: 1, EI2: 1, EI3: 1, mass_per_length: 1,
            rotary_inertia: [1.0e-6, 5.0e-7, 5.0e-7]}
    nodes: {foot: {position: [0, 0, 0], fixed: true}, tip: {position: [0, 0, 1]}}
    elements:
      rod: {type: beam, nodes: [foot, tip], section: rod, up: [1, 0, 0], mesh: 12}
      tip: {type: point_mass, node: tip, mass: 0.5}
    joints: {plane: {type: planar, nodes: [ground, tip], axis: [0, 1, 0]}}
    loads: {thrust: {type: follower_force, node: tip, direction: [0, 0, -1], value: LOAD}}
    initial: {static: {method: steps}}
    time: {end: 1, step: 1 ms}
"""


def oscillations_of_pflueger(load):
    """Return how many frequencies W below 25 rad/s has Pflueger's column of unit length, EI and mass.

    w_xxxx + P w_xx = W^2 w, w = w_x = 0 at the foot, w_xx = 0 and w_xxx = -W^2 w/2 at the tip.
    """

    def determinant(W):
        A = np.diag([1.0, 1.0, 1.0], 1)
        A[3] = W**2, 0.0, -load, 0.0
        return np.linalg.det((np.array([[0, 0, 1, 0], [0.5 * W**2, 0, 0, 1]]) @ expm(A))[:, 2:])

    values = np.array([determinant(W) for W in np.linspace(0.1, 25.0, 400)])
    return int(np.sum(values[1:] * values[:-1] < 0.0))


def test_pfluegers_column_flutters():
    """Beck's column with a mass at its tip flutters where two frequencies meet, at 16.06 EI/L^2 instead of 20.05."""
    assert [oscillations_of_pflueger(load) for load in (15.95, 16.15)] == [2, 0]
    for load in (15.95, 16.15):
        values = eigenvalues(deck(PFLUEGER.replace("LOAD", str(load))))
        fastest = values[np.argmax(values.real)]
        assert fastest.real < 1e-6 if load < 16.06 else (fastest.real > 0.1 and abs(fastest.imag) > 5.0)


PRISM = """
    mecano: 1
    gravity: none
    parameters: {tilt: 143*pi/180, twist: 5*pi/6, bar: '=sqrt(2*(1 - cos($twist)) + 2.25)'}
    nodes:
      low_$i: {repeat: {i: 0..2}, position: ['=cos(2*pi*$i/3)', '=sin(2*pi*$i/3)', 0]}
      top_$i:
        repeat: {i: 0..2}
        position: ['=cos(2*pi*$i/3 + $tilt)', '=sin(2*pi*$i/3 + $tilt)', '=sqrt($bar**2 - 2*(1 - cos($tilt)))']
    elements:
      mass_$i: {repeat: {i: 0..2}, type: point_mass, node: top_$i, mass: 0.1}
      side_$i:
        {repeat: {i: 0..2}, type: cable, nodes: [low_$i, top_$((i + 2) % 3)], axial_stiffness: 10 kN,
         natural_length: 1.5}
      edge_$i:
        {repeat: {i: 0..2}, type: cable, nodes: [top_$i, top_$((i + 1) % 3)], axial_stiffness: 10 kN,
         natural_length: 1.7}
    joints:
      bar_$i: {repeat: {i: 0..2}, type: rigid_rod, nodes: [low_$i, top_$i]}
      base_$i: {repeat: {i: 0..2}, type: spherical, nodes: [ground, low_$i]}
    static: {method: relaxation}
"""


def test_a_tensegrity_prism_twists_by_150_degrees(verify):
    """Three bars that do not touch, and prestressed cables: of all twists this one alone is in equilibrium."""
    path = Path(PRISM)
    (x, y, _), (_, _, height) = path.positions("top_0")[-1], path.positions("top_1")[-1]
    twist = np.degrees(np.arctan2(y, x))
    verify(S, "tensegrity prism: twist [deg]", twist, 150.0, "closed form (Connelly & Terrell 1995)", relative=1e-9)
    assert path.unstable[-1] == 0 and height > 1.4
