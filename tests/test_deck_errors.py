# ruff: noqa: E501
"""All messages about invalid decks, each provoked by one change of a valid deck."""

import re

import pytest
from deck_samples import VALID, problems_of, read_fake
from time_runs import deck

from mecano.deck.format import deck_error_text
from mecano.errors import DeckError

# what is written in the valid deck, what is written instead; the line, the text at the caret, the one problem
STRUCTURE = [
    ("mecano: 1", "mecano: 2", 1, "2",
     "this program reads decks of version 1, got 2; write 'mecano: 1'"),
    ("mecano: 1", "mecano: true", 1, "true",
     "this program reads decks of version 1, got true; write 'mecano: 1'"),
    ("mecano: 1\n", "", 1, "title",
     "missing 'mecano', the version of the deck; begin with 'mecano: 1'"),
    ("mecano: 1", "study: 1", 1, "study",
     "missing 'mecano', the version of the deck; this is a study: run it by `mecano sweep`"),
    ("title:", "sections:\ntitle:", 2, "",
     "'sections' must be a mapping of names, got nothing; leave it out, or write {}"),
    ("title:", "titel:", 2, "titel",
     "unknown key 'titel'; did you mean 'title'?"),
    ("\"A wheel on a leg\"", "1.0", 2, "1.0",
     "'title' must be a text, got 1.0"),
    ("sink: 3.05", "sink: fast", 3, "fast",
     "parameter 'sink': must be a number, got the text 'fast'; a word is a name or a part of one, such as axle_$sink, "
     "and no name here contains $sink"),
    ("sink: 3.05", "sink: $mas", 3, "$mas",
     "parameter 'sink': unknown parameter 'mas'; did you mean 'mass'?"),
    ("-9.81]", "-9.81, 0]", 4, "[0,",
     "'gravity' must be a list of 3 numbers, such as [0, 0, -9.81], or 'none' [m/s2], got [0, 0, -9.81, 0]"),
    ("-9.81]", "g]", 4, "g",
     "'gravity[2]' must be a number [m/s2], got the text 'g'"),
    ("[0, 0, -9.81]", "-9.81", 4, "-9.81",
     "'gravity' must be a list of 3 numbers, such as [0, 0, -9.81], or 'none' [m/s2], got -9.81"),
    ("[0, 0, 2.1]", "[0, 0, .nan]", 6, ".nan",
     "node 'top': 'position[2]' must be finite [m], got .nan"),
    ("[0, 0, 2.1]", "[0, 0, 1e400]", 6, "1e400",
     "node 'top': 'position[2]' must be finite [m], got 1e400"),
    ("[0, 0, 2.1]", "[0, 0, -1e200]", 6, "-1e200",
     "node 'top': 'position[2]' is out of range [m], got -1e200"),
    ("[0, 0, 2.1]", "[0, 0, nan]", 6, "nan",
     "node 'top': 'position[2]' must be a number [m], got the text 'nan'"),
    ("[0, 0, 2.1]", "", 6, ", f",
     "node 'top': 'position' must be a list of 3 numbers [m], got nothing"),
    ("[0, 0, 2.1]", "'[0, 0, 2.1]'", 6, "'[0",
     "node 'top': 'position' must be a list of 3 numbers [m], got the text '[0, 0, 2.1]'; write it without quotes; from "
     "Python give a list or a dict, not its text"),
    ("position: [0, 0, 2.1], ", "", 6, "top",
     "node 'top': missing 'position', a list of 3 numbers [m]: position at the start, inertial"),
    ("fixed: true", "fixed: yes", 6, "yes",
     "node 'top': 'fixed' must be true or false, got the text 'yes'; write true, without quotes"),
    ("fixed: true", "fixed: 'true'", 6, "'true'",
     "node 'top': 'fixed' must be true or false, got the text 'true'; write true, without quotes"),
    ("mass: $mass", "mass: mass", 13, "mass,",
     "body 'hub': 'mass' must be a number [kg], got the text 'mass'; a parameter begins with '$': $mass"),
    ("mass: $mass", "mass: 2026-11-29", 13, "2026-11-29",
     "body 'hub': 'mass' must be a number [kg], got the text '2026-11-29'; a number is written as 2.5 or 2.5 kg"),
    ("mass: $mass", "mass: 2*mass", 13, "2*mass",
     "body 'hub': 'mass' must be a number [kg], got the text '2*mass'; a parameter begins with '$': 2*$mass"),
    ("fixed: true", "<<: true", 6, "<<",
     "node 'top': unknown key '<<'; merge keys of YAML are not read; 'templates' and 'repeat' write similar entries"),
    ("fixed: true", "fixd: true", 6, "fixd",
     "node 'top': unknown key 'fixd'; did you mean 'fixed'?"),
    ("fixed: true", "q: true", 6, "q",
     "node 'top': unknown key 'q'; known: fixed, orientation, position"),
    ("  axle: {position: [0.25, 0, 0.3225]}", "  axle: [0, 0, 0]", 10, "[0,",
     "node 'axle': must be a mapping, got [0, 0, 0]; write {position: [0, 0, 0]}"),
    ("law: oleo", "k: 7e10", 14, "k: ",
     "spring 'absorber': unknown key 'k'; write it in the 'law': {spring: ..., damper: ...}"),
    ("mass: 7e1", "mass: 7,1 kg", 12, "1 kg",
     "a key must be a name, got '1 kg'; a decimal point, not a comma: 7.1 kg"),
    ("mass: 7e1", "mass: 7,100.5", 12, "100.5",
     "a key must be a name, got '100.5'; write 7100.5"),
    ("mass: 7e1", "mass: 7'000", 12, "7'000",
     "body 'leg': 'mass' must be a number [kg], got the text \"7'000\"; write 7000"),
    ("mass: 7e1", "mass: np.float64(7.5)", 12, "np.",
     "body 'leg': 'mass' must be a number [kg], got the text 'np.float64(7.5)'; write 7.5"),
    ("mass: 7e1", "mass: 7 000", 12, "000,",
     "body 'leg': the expression '7 000' cannot be understood; write 7000"),
    ("mass: 7e1", "mass: 7·10^3 kg", 12, "7·10",
     "body 'leg': 'mass' must be a number [kg], got the text '7·10^3 kg'; write 7e3 kg"),
    ("position: [0.0, 0.0, 1.0]", "position: 0.0, 0.0, 1.0", 8, "0.0, 0.0, 1.0",
     "node 'knee': 'position' must be a list of 3 numbers [m], got the text '0.0, 0.0, 1.0'; write [0.0, 0.0, 1.0]"),
    ("[0.25, 0, 0.3225]", "0.25, 0, 0.3225", 10, "0, ",
     "a key must be a name, got '0'; a list is written in brackets: position: [0.25, 0, ...]"),
    ("[0.25, 0, 0.3225]", "(0.25, 0, 0.3225)", 10, "0, ",
     "a key must be a name, got '0'; a list is written in brackets: position: [0.25, 0, ...]"),
    ("[0.25, 0, 0.3225]", "[0.25 0 0.3225]", 10, "[0.25",
     "node 'axle': 'position' must be a list of 3 numbers [m], got ['0.25 0 0.3225']; write [0.25, 0, 0.3225]"),
    ("nodes: [top, knee], axis", "nodes: [top knee], axis", 17, "[top",
     "hinge 'pin': 'nodes' must be a list of 2 node names, got ['top knee']; write [top, knee]"),
    ("axis: [0, 1, 0], stop_axis", "axis: -Y, stop_axis", 17, "-Y",
     "hinge 'pin': 'axis' must be a list of 3 numbers, not all zero, got the text '-Y'; write [0, -1, 0]"),
    ("mass: 7e1", "mass: -7e1", 12, "-7e1",
     "body 'leg': 'mass' must be greater than zero [kg], got -7e1"),
    ("mass: $mass", "mass: -$mass", 13, "-$mass",
     "body 'hub': 'mass' must be greater than zero [kg], got -82.0 (-$mass); $mass is given in line 3"),
    ("mass: $mass", "mass: $mas", 13, "$mas",
     "body 'hub': unknown parameter 'mas'; did you mean 'mass'?"),
    ("mass: $mass", "mass: $mass*-2", 13, "$mass*-2",
     "body 'hub': 'mass' must be greater than zero [kg], got -164.0 ($mass*-2); $mass is given in line 3"),
    ("mass: $mass", "mass: $mass*(2", 13, "(2",
     "body 'hub': the expression '$mass*(2' cannot be understood"),
    ("mass: $mass", "mass: $mass$mass", 13, "$mass,",
     "element 'hub': '$mass$mass' is read as a name, '8282'; is an operator missing?"),
    ("mass: $mass", "mass: =2*$mass$$sink", 13, "$$sink",
     "body 'hub': the expression '=2*$mass$$sink' has a $ right after '$mass'; is an operator missing?"),
    ("mass: $mass", "mass: 2 * $mas", 13, "$mas",
     "body 'hub': unknown parameter 'mas'; did you mean 'mass'?"),
    ("mass: $mass", "mass: '=sqr($mass)'", 13, "sqr(",
     "body 'hub': there is no function 'sqr'; did you mean 'sqrt'?"),
    ("mass: $mass", "mass: $mass + open('x')", 13, "'x')",
     "body 'hub': the expression \"$mass + open('x')\" may contain numbers, $parameters, + - * / ** ( ) and functions only"),
    ("mass: $mass", "mass: $mass^2/12", 13, "$mass^",
     "body 'hub': the expression '$mass^2/12' has the power ^, which is written **, as in 2**3"),
    ("mass: $mass", "mass: $mass / (1 - 1)", 13, "$mass /",
     "body 'hub': the expression '$mass / (1 - 1)' divides by zero"),
    ("mass: $mass", "mass: $mass * sink", 13, "sink",
     "body 'hub': there is no constant 'sink'; a parameter is written with a $"),
    ("sink: 3.05, mass: 82.0", "sink: $mass, mass: 2 / $sink", 3, "$mass",
     "parameter 'sink': parameters depend on one another in a circle: sink -> mass -> sink"),
    ("count: $steps", "count: 1.5", 12, "1.5",
     "body 'leg': 'count' must be a whole number, got 1.5"),
    ("count: $steps", "count: $sink", 12, "$sink",
     "body 'leg': 'count' must be a whole number, got 3.05 ($sink); $sink is given in line 3"),
    ("count: $steps", "count: 0", 12, "0",
     "body 'leg': 'count' must be greater than zero, got 0"),
    ("[2.0e3, 2e3, 2000]", "[1, 2, 3, 4]", 12, "[1,",
     "body 'leg': 'inertia' must be 3 principal moments, 6 numbers [xx, yy, zz, xy, xz, yz], or a 3x3 symmetric matrix [kg m2], got [1, 2, 3, 4]"),
    ("[2.0e3, 2e3, 2000]", "[[1, 0, 0], [0, 1], [0, 0, 1]]", 12, "[[1",
     "body 'leg': 'inertia' must be 3 principal moments, 6 numbers [xx, yy, zz, xy, xz, yz], or a 3x3 symmetric matrix [kg m2], got a list of 3"),
    ("[[1, 0, 0]", "[[1, 0, x]", 13, "x",
     "body 'hub': 'inertia[0][2]' must be a number [kg m2], got the text 'x'"),
    ("[top], count", "top, count", 12, "top",
     "body 'leg': 'attached' must be a list of node names, got the text 'top'; write [top]"),
    ("[top], count", "[3], count", 12, "3",
     "body 'leg': 'attached[0]' must be the name of a node, got 3"),
    ("type: wheel", "type: whel", 15, "whel",
     "element 'wheel': unknown type 'whel'; did you mean 'wheel'?"),
    ("type: wheel", "type: hinge", 15, "hinge",
     "element 'wheel': kind 'hinge' belongs to 'joints', not 'elements'"),
    ("type: wheel", "type: 3", 15, "3",
     "element 'wheel': 'type' must be the name of a kind, got 3"),
    ("type: wheel, ", "", 15, "wheel",
     "element 'wheel': missing 'type'; with these keys: wheel"),
    ("type: wheel, ", "extra: 1, ", 15, "wheel",
     "element 'wheel': missing 'type'; known: body, spring, wheel"),
    ("type: wheel, ", "<<: {type: wheel}, ", 15, "<<",
     "element 'wheel': unknown key '<<'; merge keys of YAML are not read; 'templates' and 'repeat' write similar entries"),
    ("axis: [0, 1, 0], tire", "axis: [0, 0, 0.0], tire", 15, "[0,",
     "wheel 'wheel': 'axis' must be a list of 3 numbers, not all zero, got [0, 0, 0.0]"),
    ("tire_law: nose, ", "", 15, "wheel",
     "wheel 'wheel': missing 'tire_law', the name of a tire law: tyre"),
    ("tire_law: nose", "tire_law: {radius: 1}", 15, "{ra",
     "wheel 'wheel': 'tire_law' must be the name of a tire law, got a mapping"),
    ("nodes: [top, knee]", "nodes: [top, knee, axle]", 17, "[to",
     "hinge 'pin': 'nodes' must be a list of 2 node names, got ['top', 'knee', 'axle']"),
    ("stop_axis: [1, 0, 0]", "frame: inertal", 17, "inertal",
     "hinge 'pin': 'frame' cannot be 'inertal'; did you mean 'inertial'?"),
    ("stop_axis: [1, 0, 0]", "frame: 3", 17, "3",
     "hinge 'pin': 'frame' must be one of: inertial, material, got 3"),
    ("[[0, 0], [1, 1e3]]", "[[0, 0], [1]]", 20, "[1]",
     "force 'push': 'value.table.points[1]' must be two numbers, got [1]"),
    ("[[0, 0], [1, 1e3]]", "[[0, 0], [1, a]]", 20, "a",
     "force 'push': 'value.table.points[1][1]' must be a number [N], got the text 'a'"),
    ("[[0, 0], [1, 1e3]]", "7", 20, "7",
     "force 'push': 'value.table.points' must be a list of [x, y] pairs, got 7"),
    ("[[0, 0], [1, 1e3]]", "[[0, 0], [0, 1e3]]", 20, "[[0",
     "force 'push': 'value.table.points' must have strictly increasing x: point 2 has 0.0 after 0.0, got a list of 2"),
    ("{points: [[0, 0], [1, 1e3]]}", "{}", 20, "table",
     "force 'push': table: one of 'points' and 'file' must be given"),
    ("{table: {points: [[0, 0], [1, 1e3]]}}", "[1]", 20, "[1]",
     "force 'push': 'value' must be a number, the name of a law, or a law of one variable written in place [N], got [1]"),
    ("{table: {points: [[0, 0], [1, 1e3]]}}", "{}", 20, "{}}",
     "force 'push': a law needs at least one term; known: "),
    ("{table: {points: [[0, 0], [1, 1e3]]}}", "{damper: {coefficient: 1}}", 20, "damper",
     "force 'push': 'damper' is a force of extension and rate; a number, the name of a law, or a law of one variable written in place is required here"),
    ("{table: {points: [[0, 0], [1, 1e3]]}}", "{spring: 2}", 20, "spring",
     "force 'push': 'spring' is a force of extension and rate; a number, the name of a law, or a law of one variable written in place is required here; a force in proportion to it is {linear: ...}"),
    ("law: oleo", "law: 7", 14, "7",
     "spring 'absorber': 'law' must be the name of a law, or a law written in place [N], got 7; write {spring: 7}, if it is a stiffness"),
    ("damper: {", "dampr: {", 24, "dampr",
     "law 'oleo': unknown term 'dampr' of a law; did you mean 'damper'?"),
    ("damper: {", "damping: {", 24, "damping",
     "law 'oleo': unknown term 'damping' of a law; write {damper: ...}"),
    ("damper: {", "torsional_damper: {", 24, "torsional_damper",
     "law 'oleo': unknown term 'torsional_damper' of a law; write {damper: ...}"),
    ("damper: {", "xyzzy: {", 24, "xyzzy",
     "law 'oleo': unknown term 'xyzzy' of a law; `mecano explain laws` lists the terms"),
    ("damper: {", "pulse: {", 24, "pulse",
     "law 'oleo': unknown term 'pulse' of a law; write {bump: ...}"),
    ("damper: {coefficient: 1.19e4}", "damper: {}", 24, "damper",
     "law 'oleo': missing 'damper.coefficient', a number [N s/m or N m s/rad]: force per rate"),
    ("damper: {coefficient: 1.19e4}", "damper: soft", 24, "soft",
     "law 'oleo': 'damper.coefficient' must be a number [N s/m or N m s/rad], got the text 'soft'"),
    ("upper: 0.3,", "upper: 0.3, lower: 0.4,", 25, "0.4",
     "law 'oleo': stop: 'lower' must be less than 'upper'"),
    ("smooth: 0.8", "smooth: oleo", 26, "oleo",
     "law 'smooth': must be a number or a mapping of terms, got the text 'oleo'"),
    ("smooth: 0.8", "smooth: .inf", 26, ".inf",
     "law 'smooth': must be finite, got .inf"),
    ("nodes: all", "nodes: al", 35, "al",
     "'initial.velocities[0].nodes' must be a list of names of nodes and members or 'all', got the text 'al'; did you mean 'all'?"),
    ("nodes: all", "nodes: []", 35, "[],",
     "'initial.velocities[0].nodes' must not be empty, got []"),
    ("nodes: all", "nodes: [axle, axle]", 35, "[axle,",
     "'initial.velocities[0].nodes' must not name 'axle' twice, got ['axle', 'axle']"),
    ("nodes: all", "nodes: all, angular_velocity: [0, 0, 1]", 35, "{no",
     "initial.velocities[0]: 'about' is missing: the point about which the nodes turn, or 'own' for each about itself"),
    ("  end: 4.0\n", "", 37, "time",
     "missing 'time.end', a number [s]: time at the end"),
    ("step: 1e-3", "step: 0", 39, "0",
     "'time.step' must be greater than zero [s], got 0"),
    ("step: 1e-3", "step: 5", 39, "5",
     "time: 'step' must not be longer than the time from 'start' to 'end'"),
    ("end: 4.0", "end: -4", 38, "-4",
     "time: 'end' must be later than 'start', 0 s"),
    ("end: 4.0", "end: 4.0\n  rho_inf: 1.1", 39, "1.1",
     "'time.rho_inf' must lie between 0 and 1, got 1.1"),
    ("end: 4.0", "end: 4.0\n  rho_inf: 0.4\n  method: hht", 39, "0.4",
     "time: 'rho_inf' must be at least 0.5 with the method hht"),
    ("end: 4.0", "end: 4.0\n  rho_inf: 0.9\n  method: newmark", 39, "0.9",
     "time: 'rho_inf' must be 1 with the method newmark and 'adaptive': with numerical damping newmark is of first "
     "order, and its errors exceed the tolerance"),
    ("end: 4.0", "end: 4.0\n  method: rk4", 39, "rk4",
     "'time.method' cannot be 'rk4'; known: generalized_alpha, hht, newmark, radau"),
    ("end: 4.0", "end: 4.0\n  newton: {maximum_iterations: 0}", 39, "0",
     "'time.newton.maximum_iterations' must be at least 1, got 0"),
    ("end: 4.0", "end: 4.0\n  scale: {penalty: -1}", 39, "-1",
     "'time.scale.penalty' must not be negative [N/m], got -1"),
    ("tolerance: 1e-4", "tolerance: 2", 40, "2",
     "'time.adaptive.tolerance' must lie between 1e-12 and 1, got 2"),
    ("tolerance: 1e-4", "tolerance: 1e-4, maximum_step: 1e-4", 39, "1e-3",
     "time: 'step' must not be greater than 'adaptive.maximum_step'"),
    ("tolerance: 1e-4", "tolerance: 1e-4, minimum_step: 1e-2", 39, "1e-3",
     "time: 'step' must not be less than 'adaptive.minimum_step'"),
    ("every: 5e-3", "every: stop", 41, "stop",
     "'output.every' must be a number or 'step' [s], got the text 'stop'; did you mean 'step'?"),
    ("every: 5e-3", "every: 0", 41, "0",
     "'output.every' must be greater than zero [s], got 0"),
    ("output: {every: 5e-3}", "output: true", 41, "true",
     "'output' must be a mapping, got true; write {}, for all its defaults"),
    ("output: {every: 5e-3}", "output: 3", 41, "3",
     "'output' must be a mapping, got 3; write {every: 3}"),
    ("  top: {", "  ground: {", 6, "ground",
     "node 'ground': the name 'ground' is reserved"),
    ("  top: {", "  2nd: {", 6, "2nd",
     "node '2nd': a name begins with a letter from a to z or '_', and contains only such letters, digits, '_' and '-'"),
]  # fmt: skip
NAMES = [
    ("law: oleo", "law: oloe", 14, "oloe",
     "spring 'absorber': unknown law 'oloe'; did you mean 'oleo'?"),
    ("law: oleo", "law: $oleo", 14, "$oleo",
     "spring 'absorber': unknown parameter 'oleo'; known: sink, mass, steps"),
    ("ground: runway", "ground: sea", 15, "sea",
     "wheel 'wheel': unknown ground 'sea'; known: runway"),
    ("tire_law: nose", "tire_law: noes", 15, "noes",
     "wheel 'wheel': unknown tire law 'noes'; did you mean 'nose'?"),
    ("[top, knee]", "[top, kne]", 17, "kne",
     "hinge 'pin': unknown node 'kne'; did you mean 'knee'?"),
    ("[top, knee]", "[top, p$i]", 17, "p$i",
     "hinge 'pin': unknown node 'p$i'; names contain parameters, and values of a 'repeat' of the same entry: p$last, "
     "{repeat: {i: 1..$last}, node: p$i}"),
    ("[top, knee]", "[top, p$sink]", 17, "$sink",
     "joint 'pin': only whole numbers and words can be part of a name; $sink is 3.05"),
    ("[ground, axle]", "[axle, grond]", 18, "grond",
     "hinge 'held': unknown node 'grond'; did you mean 'ground'?"),
    ("[ground, axle]", "[ground, ground]", 18, "ground",
     "hinge 'held': unknown node 'ground'; 'ground' is allowed only as one of two nodes; otherwise use a node with 'fixed: true'"),
    ("friction: smooth", "friction: oleo", 28, "oleo",
     "tire law 'nose': law 'oleo' is a force of extension and rate ('damper'); a curve is required here"),
    ("nodes: [axle], ang", "nodes: [axel], ang", 36, "axel",
     "unknown node 'axel'; did you mean 'axle'?"),
]  # fmt: skip
PHYSICS = [
    ("node: axle, mass", "node: knee, attached: [knee], mass", 13, "hub",
     "body 'hub': node 'knee' is named twice"),
    ("[top, knee]", "[top, top]", 17, "pin",
     "hinge 'pin': node 'top' is named twice"),
    ("[0.25, 0, 0.3225]", "[0, 0, 1]", 14, "[kn",
     "spring 'absorber': 'nodes' are at the same place: the spring has no direction"),
    ("stop_axis: [1", "stop_axis: [0, 3", 17, "[0,",
     "hinge 'pin': 'stop_axis' must be a list of 3 numbers, not all zero, got [0, 3, 0, 0]"),
    ("stop_axis: [1, 0, 0]", "stop_axis: [0, -2, 0]", 17, "[0,",
     "hinge 'pin': 'stop_axis' must not be parallel to 'axis'"),
    ("  axle: {", "  idle: {position: [0, 0, 0]}\n  axle: {", 10, "idle",
     "node 'idle': no element or joint is connected to it; connect or delete it"),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "line", "caret", "text"), STRUCTURE + NAMES + PHYSICS)
def test_one_problem(old, new, line, caret, text):
    assert VALID.count(old) == 1
    with pytest.raises(DeckError) as info:
        read_fake(VALID.replace(old, new))
    (problem,) = info.value.problems
    assert (problem.mark.file, problem.mark.line) == ("deck.yaml", line)
    assert problem.mark.text[problem.mark.column - 1 :].startswith(caret)
    found = problem.message + (f"; {problem.hint}" if problem.hint else "")
    assert found.startswith(text) if text.endswith("known: ") else found == text


@pytest.mark.parametrize(
    ("text", "hint"),
    [
        ("nodes:\n  pin:{position: [0, 0, 0]}\n", "write a space after 'pin:'"),
        ("nodes:\n  pin$i:{position: [0, 0, 0], fixed: true}\n", "write a space after 'pin$i:'"),
        ("nodes:\n  pin: a: b\n", "put a text with ': ' in quotes; keys that belong together begin in the same column"),
        ("nodes:\n  - {name: pin, position: [0, 0, 0]}\n", "begin each entry with its name and ':', not with '-'"),
        ("nodes: [pin, tip]\n", ""),
    ],
)
def test_hints_on_what_is_no_mapping(text, hint):
    with pytest.raises(DeckError) as info:
        read_fake("mecano: 1\ngravity: none\n" + text)
    assert info.value.problems[0].hint == hint


@pytest.mark.parametrize("entries", ["  ", ""], ids=["with its entries", "its first line alone"])
@pytest.mark.parametrize(
    ("section", "before"),
    [
        ("nodes", "parameter"),
        ("elements", "node"),
        ("joints", "element"),
        ("loads", "joint"),
        ("laws", "load"),
        ("signals", "law"),
        ("grounds", "signal"),
    ],
)
def test_an_indented_section_is_one_mistake(section, before, entries):
    """Not that its entries, what refers to them, or the section itself are missing."""
    text = """mecano: 1
gravity: none
parameters:
  speed: 1
nodes:
  pin: {position: [0, 0, 0]}
elements:
  bar: {type: rigid_body, node: pin, mass: 1, inertia: [1, 1, 1]}
joints:
  hinge: {type: hinge, nodes: [ground, pin], axis: [0, 1, 0]}
loads:
  push: {type: force, node: pin, direction: [1, 0, 0], value: pull}
  turn: {type: joint_moment, joint: hinge, value: height}
laws:
  pull: {constant: 3}
signals:
  height: pin.position.z
  twice: 2*height
grounds:
  road: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}
time: {end: 1, step: 0.1}
"""
    head, start, tail = text.partition(f"{section}:\n")
    own, end, rest = re.split(r"^(?=\w)()", tail, maxsplit=1, flags=re.M)
    indented = head + "  " + start + re.sub("^", entries, own.rstrip("\n"), flags=re.M) + "\n" + rest
    with pytest.raises(DeckError) as info:
        deck(indented)
    (problem,) = info.value.problems
    assert problem.message == f"{before} '{section}': this is a section"
    assert problem.hint == "begin it in the first column"


def test_sections_inside_an_entry_and_inside_others():
    text = """mecano: 1
gravity: none
nodes: {pin: {position: [0, 0, 0]}}
elements:
  bar:
    type: point_mass
    node: pin
    mass: 1
    joints:
      hold: {type: spherical, nodes: [ground, pin], release: {time: 1}}
time:
  end: 1
  step: 0.1
  output: {every: 0.1}
"""
    with pytest.raises(DeckError) as info:
        deck(text)
    assert [problem.message for problem in info.value.problems] == [
        "point_mass 'bar': 'joints' is a section",
        "'time.output' is a section",
    ]


@pytest.mark.parametrize(
    ("entry", "hint"),
    [
        ("{type: spherical, nodes: [ground, pin], stops: {upper: 1}}",
         "it is a field of hinge, cylindrical, prismatic, screw"),
        ("{type: spherical, node: [ground, pin]}", "did you mean 'nodes'?"),
    ],
)  # fmt: skip
def test_fields_of_other_kinds(entry, hint):
    text = f"""mecano: 1
gravity: none
nodes: {{pin: {{position: [0, 0, 0]}}}}
elements: {{bar: {{type: point_mass, node: pin, mass: 1}}}}
joints: {{hold: {entry}}}
time: {{end: 1, step: 0.1}}
"""
    with pytest.raises(DeckError) as info:
        deck(text)
    assert info.value.problems[0].hint == hint


def test_the_deck_itself_is_valid():
    assert read_fake(VALID).values["time"]["end"] == 4.0


def test_missing_sections_are_all_named():
    assert [text.split(",")[0] for text in problems_of("mecano: 1\n")] == [
        "1:1 missing 'nodes'",
        "1:1 missing 'elements'",
        "1:1 missing 'time'",
    ]


def test_empty_sections():
    text = "mecano: 1\nnodes: {}\nelements: {}\ntime: {end: 1, step: 0.1}\n"
    assert problems_of(text) == [
        "2:8 'nodes' must not be empty",
        "3:11 'elements' must not be empty",
    ]


def test_list_of_names_without_brackets():
    problems = problems_of(VALID.replace("attached: [top]", "attached: top, knee"))
    assert problems[-1].endswith("unknown key 'knee'; a list is written in brackets: [top, knee]")


def test_a_misspelt_node_with_the_name_of_an_element_gets_both_hints():
    text = VALID.replace("  knee:", "  kneee:").replace("  leg:", "  knee:")
    hint = "'knee' is an element; did you mean 'kneee'?"
    assert any(problem.endswith(f"unknown node 'knee'; {hint}") for problem in problems_of(text))


def test_names_in_one_item_of_a_list():
    (problem,) = problems_of(VALID.replace("attached: [top]", "attached: [top axle]"))
    assert problem.endswith("unknown node 'top axle'; each name is an item of its own: top, axle")


@pytest.mark.parametrize("name,hint", [("7", "a name begins with a letter, such as n1"), ("true", "put it in quotes")])
def test_keys_that_are_no_names(name, hint):
    text = VALID.replace("  axle: {position", f"  {name}: {{position")
    assert problems_of(text)[0] == f"10:3 a key must be a name, got '{name}'; {hint}"


def test_parameters_by_another_name_are_refused_once():
    text = VALID.replace("parameters: {", "variables: {")
    assert problems_of(text) == ["3:1 unknown key 'variables'; here it is called 'parameters'"]


def test_a_key_that_is_a_word_of_a_longer_one():
    found = problems_of(VALID + "tire: {}\n")
    assert found[0].endswith("unknown key 'tire'; did you mean 'tire_laws'?")


def test_all_problems_of_a_step_at_once():
    text, expected = VALID, set()
    for old, new, line, _, problem in STRUCTURE[4:]:
        if (
            text.count(old) == 1
            and "time: " not in problem
            and "\n" not in new + old
            and line not in {at for at, _ in expected}
        ):
            text = text.replace(old, new)
            expected.add((line, problem))
    assert len(expected) == 19
    found = {(int(at.split(":")[0]), problem) for at, problem in (p.split(" ", 1) for p in problems_of(text))}
    assert expected <= found


def test_problems_of_yaml_and_structure_come_together():
    found = problems_of(VALID.replace("title:", "titel:") + "output: {every: 1}\n")
    assert found == [
        "2:1 unknown key 'titel'; did you mean 'title'?",
        "42:1 duplicate key 'output', first given in line 41",
    ]


def test_unknown_names_come_with_the_structure():
    """But not those of a section that is wrong as a whole, or has another name."""
    text, unknown = VALID.replace("law: oleo", "law: oloe"), "spring 'absorber': unknown law 'oloe'"
    wrong = text.replace("title:", "titel:").replace("[top, knee]", "[top, kne]")
    assert [problem.split("; did")[0] for problem in problems_of(wrong)] == [
        "2:1 unknown key 'titel'", f"14:54 {unknown}", "17:35 hinge 'pin': unknown node 'kne'",
    ]  # fmt: skip
    assert [problem.split("; did")[0] for problem in problems_of(text.replace("laws:", "lawss:"))][:1] != [unknown]
    assert not any("unknown law" in problem for problem in problems_of(text.replace("laws:", "lawss:")))


def test_what_was_not_checked_yet_is_said():
    """The physics of a deck whose parts are wrong; when only that is left, nothing."""
    for old, new, said in [("title:", "titel:", True), ("law: oleo", "law: oloe", True), ("mass: 7e1", "mass: 0", True),
                           ("[0.25, 0, 0.3225]", "[0, 0, 1]", False)]:  # fmt: skip
        with pytest.raises(DeckError) as info:
            read_fake(VALID.replace(old, new))
        assert ("1 error; consistency is checked once this error is fixed" in deck_error_text(info.value)) == said
    with pytest.raises(DeckError) as info:
        read_fake(VALID.replace("title:", "titel:").replace("mass: 7e1", "mass: 0"))
    assert deck_error_text(info.value).endswith("2 errors; consistency is checked once these errors are fixed")


def test_known_words_are_not_looked_up_for_ever():
    """Similar words are sought for the first problems only, and never for very long words."""
    unknown = "".join(f"  n{i}: {{position: [0, 0, 0], kind{i}: 1}}\n" for i in range(300))
    found = problems_of(f"mecano: 1\nnodes:\n{unknown}")
    assert sum("known:" in text for text in found) == 100
    (long,) = problems_of(VALID.replace("law: oleo", "law: " + "x" * 1_000_000))
    assert len(long) < 200 and long.startswith("14:54 spring 'absorber': unknown law 'xxx")


def test_a_flood_of_problems_ends():
    unknown = "".join(f"  n{i}: 1\n" for i in range(20_000))
    assert len(problems_of(f"mecano: 1\nnodes:\n{unknown}")) == 10_000


def test_the_error_is_one_a_command_line_can_return():
    with pytest.raises(DeckError) as info:
        read_fake("mecano: 1")
    assert info.value.exit_code == 2


def test_an_inner_diameter_is_told_as_a_thickness():
    """Then the thickness is not missing."""
    section = "s: {type: tube, diameter: 200 mm, inner_diameter: 170 mm, E: 205 GPa, nu: 0.3, density: 7850}"
    text = "mecano: 1\ngravity: none\nsections:\n  " + section + "\n"
    text += "nodes: {a: {position: [0, 0, 0]}, b: {position: [1, 0, 0]}}\n"
    text += "elements: {e: {type: beam, nodes: [a, b], section: s}}\ntime: {end: 1, step: 0.1}\n"
    hint = "give the 'thickness' of the wall, half the difference of both diameters"
    found = [text for text in problems_of(text) if "tube" in text]  # the kinds of these tests have no beam
    assert found == [f"4:37 tube 's': unknown key 'inner_diameter'; {hint}"]


def test_a_key_that_is_misspelt_in_many_entries_is_one_error_in_each():
    """Also beyond the number of hints that a deck is given: the key that is meant is not missing besides."""
    nodes = "".join(f"  n{i}: {{positon: [0, 0, 0]}}\n" for i in range(150))
    found = problems_of(f"mecano: 1\ngravity: none\nnodes:\n{nodes}")
    misspelt = [text for text in found if "n149" in text or "unknown key 'positon'" in text]
    assert len(misspelt) == 150 and all("did you mean 'position'?" in text for text in misspelt)
    assert not any("missing 'position'" in text for text in found)
