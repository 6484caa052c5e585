"""Structures of textbooks and of NAFEMS, compared with closed forms and published numbers."""

import numpy as np
from equilibria import Equilibrium, Path
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
