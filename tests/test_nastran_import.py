"""`mecano import`: punch files of Nastran, written here in its formats, and in millimetres and tonnes."""

import math

import numpy as np
import pytest
from process import flowing, mecano_process
from time_runs import deck

from mecano.analyses.nastran_cards import read_cards
from mecano.analyses.nastran_matrices import Units, import_matrices, matrices_of
from mecano.analyses.reduction import reduce_part
from mecano.errors import UsageError

MM = Units(1e-3, 1e3)
BAR = """
mecano: 1
gravity: [0, 0, 0]
nodes: {root: {position: [0.2, 0.1, 0]}, tip: {position: [1.2, 0.6, 0.3]}}
sections: {flat: {type: rectangle, width: 0.02, height: 0.05, E: 7.0e10, nu: 0.3, density: 2700, damping: 1.0e-4}}
elements: {bar: {type: beam, nodes: [root, tip], section: flat, up: [0, 0, 1], mesh: 6}}
time: {end: 1, step: 0.1}
"""
TURN = np.array([[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]]).T  # axes of the system 7
ORIGIN = np.array([100.0, -40.0, 25.0])  # mm


def large(name, *fields):
    """Return a card in large fields, with its continuations."""
    texts = [f"{field:>16}" if isinstance(field, str) else number(field) for field in fields]
    texts += [" " * 16] * (-len(texts) % 4)
    lines = ["".join(texts[i : i + 4]).rstrip() for i in range(0, len(texts), 4)]
    return "\n".join(f"{'*' if i else name + '*':<8}{line}" for i, line in enumerate(lines)) + "\n"


def number(value):
    return f"{value:16d}" if isinstance(value, int) else f"{value:16.9E}".replace("E", "D")


def column(name, index, A, j, pairs):
    entries = [(i, A[i, j]) for i in range(j, len(A)) if A[i, j]]
    if not entries:
        return ""
    fields = [x for i, value in entries for x in (*index[i], value, "")]
    return large("DMIG", f"{name:<16}", *index[j], "", *fields)


def punch(content, nodes=(11, 12), systems=(0, 8), amplitudes=2001):
    """Return a punch file of reduced matrices in mm, t, s; node i has displacements in ``systems[i]``."""
    X, n = 1e3 * content["positions"], 6 * len(nodes)
    size = np.ones(len(content["mass"]))
    for i in range(0, n, 6):
        size[i : i + 3] = 1e-3
    index = [(node, c) for node in nodes for c in range(1, 7)]
    index += [(amplitudes + i, 0) for i in range(len(size) - n)]
    turn = np.eye(len(size))
    turn[6:9, 6:9] = turn[9:12, 9:12] = TURN
    text = "$ STANDARD PUNCH (.PCH) FILE FOR EXTERNAL SUPERELEMENT      1\nBEGIN SUPER        1\n$\n"
    text += large("CORD2R", 8, 7, *(0.0,) * 3, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0)  # before the system to which it refers
    text += large("CORD2R", 7, 0, *ORIGIN, *(ORIGIN + TURN[:, 2]), *(ORIGIN + TURN[:, 0]))
    text += f"EXTRN   {nodes[0]:8d}  123456{nodes[1]:8d}  123456\n"
    text += large("GRID", nodes[0], 0, *X[0], systems[0], 0, 0)
    text += large("GRID", nodes[1], 7, *(TURN.T @ (X[1] - ORIGIN)), systems[1], 0, 0)
    for name, key, scale in (("KAAX", "stiffness", 1.0), ("MAAX", "mass", 1.0), ("BAAX", "damping", 1.0)):
        A = 1e3 * scale * turn.T @ (content[key] * np.outer(size, size)) @ turn
        text += f"DMIG    {name:<8}{0:8d}{6:8d}{2:8d}{0:8d}{'':16}{len(A):8d}\n"
        text += "".join(column(name, index, A, j, None) for j in range(len(A)))
    return text


@pytest.fixture(scope="module")
def bar(tmp_path_factory):
    """The reduced matrices of a bar, its axes inertial."""
    _, result = reduce_part(deck(BAR), tmp_path_factory.mktemp("bar") / "bar.npz", nodes=["root", "tip"], number=4)
    return result.content


def test_a_punch_file_in_mm_has_the_matrices_it_was_written_from(bar, tmp_path):
    (tmp_path / "bar.pch").write_text(punch(bar))
    text = import_matrices(tmp_path / "bar.pch", tmp_path / "bar.npz", MM)
    with np.load(tmp_path / "bar.npz") as found:
        assert sorted(found) == ["damping", "mass", "positions", "stiffness"]
        X = bar["positions"]
        np.testing.assert_allclose(found["positions"] - found["positions"][0], X - X[0], atol=1e-10)
        for key in ("stiffness", "mass", "damping"):
            scale = np.sqrt(np.diag(bar[key]))
            np.testing.assert_allclose(
                found[key] / np.outer(scale, scale), bar[key] / np.outer(scale, scale), atol=1e-8
            )
    length = math.sqrt(1.0 + 0.25 + 0.09)
    assert f"mass             {2700 * 0.02 * 0.05 * length:.6g} kg" in text
    assert "boundary nodes 11, 12; 4 modes" in text


def test_the_command_converts_and_a_deck_uses_what_it_writes(bar, tmp_path):
    """The imported bar at 1 rad/s about its axis z through the first node: its kinetic energy is that of the mass."""
    (tmp_path / "bar.pch").write_text(punch(bar))
    code, out, errors = mecano_process("import", "bar.pch", "--length", "mm", "--mass", "t", cwd=tmp_path)
    assert (code, errors) == (0, "") and "boundary held" in out
    x = bar["positions"][1] - bar["positions"][0]
    (tmp_path / "deck.yaml").write_text(f"""
mecano: 1
gravity: [0, 0, 0]
nodes: {{a: {{position: [0, 0, 0]}}, b: {{position: {x.tolist()}}}}}
elements: {{bar: {{type: superelement, nodes: [a, b], file: bar.npz}}}}
time: {{end: 1, step: 0.1}}
""")
    assert mecano_process("check", "deck.yaml", cwd=tmp_path)[0] == 0
    code, _, errors = mecano_process("import", "bar.pch", cwd=tmp_path)
    assert code == 5 and "--force" in errors
    code, _, errors = mecano_process("import", "bar.pch", "--length", "t", "--force", cwd=tmp_path)
    assert code == 2 and "a length [m] is expected, and 't' is a mass" in flowing(errors)


def test_fields_of_all_widths():
    """Large numbers without blanks between them, exponents without a letter, continuations with and without marks."""
    text = (
        "$ a comment\n"
        "CORD2R *20110001                        0.193357753101591.00748371824434\n"
        "*       2.4972445000902811.498657755528812.3121940571224101.210940186196\n"
        "*       99.54392737157771.00748371824433-8.8809942249643                \n"
        "GRID   *20110038        20110001        -.002458768782937.271236428543-4\n"
        "*       -.1036                                                          \n"
        "GRID,5,,1.0,2.5-3,+3.,7\n"
        "DMIG    KAAX           0       6       1       0                      78\n"
        "DMIG*   KAAX                           2               1\n"
        "*                      1               1-1.866666647D+07\n"
        "ASET    20110010  12345620110020  12345620110030  12345620110031  123456+A1\n"
        "+A1     20110032  123456\n"
    )
    system, first, second, header, column, aset = read_cards(text)
    assert [system.number(i) for i in range(2, 11)] == [
        0.19335775310159, 1.00748371824434, 2.49724450009028, 11.4986577555288, 12.3121940571224,
        101.210940186196,
        99.5439273715777, 1.00748371824433, -8.8809942249643,
    ]  # fmt: skip
    assert (first.line, first.integer(0), first.integer(1)) == (5, 20110038, 20110001)
    assert [first.number(i) for i in (2, 3, 4)] == [-0.00245876878293, 7.271236428543e-4, -0.1036]
    assert [second.number(i) for i in range(2, 5)] == [1.0, 2.5e-3, 3.0] and second.integer(5) == 7
    assert (header.field(0), header.integer(1), header.integer(2)) == ("KAAX", 0, 6)
    assert (column.integer(4), column.integer(5), column.number(6)) == (1, 1, -1.866666647e7)
    assert aset.fields[8:10] == ["20110032", "123456"]


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("KAAX", "PAAX", "a part has one pair of matrices DMIG of stiffness and mass"),
        ("CORD2R*", "CORD2C*", "which is not a CORD2R of the file"),
        ("GRID*  ", "NODE*  ", "no GRID 11, of which the matrices have rows"),
        ("  123456", "     123", "line 10: node 11 has the components 123; a superelement needs 123456"),
        ("*                     11               1", "*                     1x               1", "'1x' in a card"),
    ],
)
def test_files_that_describe_no_part(bar, old, new, said):
    with pytest.raises(UsageError) as error:
        matrices_of(read_cards(punch(bar).replace(old, new)), MM)
    assert said in str(error.value)


def test_displacements_in_another_system_than_that_of_their_node_resist_rigid_motions(bar):
    with pytest.raises(UsageError, match="'stiffness' resists a rigid translation"):
        matrices_of(read_cards(punch(bar, systems=(0, 0))), MM)
