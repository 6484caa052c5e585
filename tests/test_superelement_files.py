"""Files of reduced matrices: all formats are equivalent, and errors are reported."""

import json

import h5py
import numpy as np
import pytest
from scipy.io import mmwrite

from mecano.deck.read import deck_of_bytes
from mecano.errors import DeckError

DECK = """
mecano: 1
gravity: [0, 0, -9.81]
nodes:
  a: {position: [1, 0, 0], orientation: [0, 0, 1.5707963267948966]}
  b: {position: [1, 2, 0]}
elements:
  arm: {type: superelement, nodes: [a, b], file: FILE}
time: {end: 1, step: 0.1}
"""
L, EA, EI, GJ, M = 2.0, 500.0, 30.0, 20.0, 3.0


def bar():
    """A bar of length L along x: stiffness of beam theory, mass in two halves with rotary inertia, one mode."""
    K = np.zeros((13, 13))
    for i, j, s in ((0, 6, EA / L), (3, 9, GJ / L)):
        K[np.ix_([i, j], [i, j])] = s * np.array([[1, -1], [-1, 1]])
    bend = EI / L**3 * np.array([[12, 6 * L, -12, 6 * L], [6 * L, 4 * L * L, -6 * L, 2 * L * L],
                                 [-12, -6 * L, 12, -6 * L], [6 * L, 2 * L * L, -6 * L, 4 * L * L]])  # fmt: skip
    sign = np.diag([1.0, -1.0, 1.0, -1.0])
    K[np.ix_([1, 5, 7, 11], [1, 5, 7, 11])] = bend
    K[np.ix_([2, 4, 8, 10], [2, 4, 8, 10])] = sign @ bend @ sign
    K[12, 12] = 400.0
    mass = np.diag([M / 2] * 3 + [0.1] * 3 + [M / 2] * 3 + [0.1] * 3 + [M])
    return {"positions": np.array([[0.0, 0, 0], [L, 0, 0]]), "stiffness": K, "mass": mass}


def read(folder, content, text=DECK):
    """The deck with a file of that content."""
    np.savez(folder / "arm.npz", **content)
    return deck_of_bytes(text.replace("FILE", "arm.npz").encode(), str(folder / "deck.yaml"))


def values(deck):
    return {key: value for key, value in deck.values["elements"]["arm"]["file"].items() if value is not None}


def test_all_formats_mean_the_same(tmp_path):
    content = bar()
    expected = values(read(tmp_path, content))
    assert expected == {key: array.tolist() for key, array in content.items()}
    np.save(tmp_path / "mass.npy", content["mass"])
    (tmp_path / "parts").mkdir()
    for place in (tmp_path, tmp_path / "parts"):
        mmwrite(place / "stiffness.mtx", content["stiffness"], symmetry="symmetric", precision=17)
        np.save(place / "mass.npy", content["mass"])
    header = f"positions: {content['positions'].tolist()}\nstiffness: stiffness.mtx\nmass: mass.npy\n"
    (tmp_path / "parts" / "arm.yaml").write_text(header)
    with h5py.File(tmp_path / "arm.h5", "w") as file:
        file["positions"], file["mass"], file["stiffness"] = content["positions"], content["mass"], "stiffness.mtx"
    inline = json.dumps({key: array.tolist() for key, array in content.items()})
    for name in ("parts/arm.yaml", "arm.h5", inline):
        deck = deck_of_bytes(DECK.replace("FILE", name).encode(), str(tmp_path / "deck.yaml"))
        assert values(deck) == expected, name
    deck = deck_of_bytes(DECK.replace("FILE", "parts/arm.yaml").encode(), str(tmp_path / "deck.yaml"))
    assert set(deck.files) == {"parts/arm.yaml", "parts/stiffness.mtx", "parts/mass.npy"}
    again = deck_of_bytes(json.dumps(deck.resolved()).encode(), str(tmp_path / "resolved.yaml"))
    assert values(again) == expected


def changed(key, change):
    content = bar()
    content[key] = change(content[key].copy())
    return content


def entry(i, j, value):
    def change(A):
        A[i, j] = value
        return A

    return change


@pytest.mark.parametrize(
    ("content", "text"),
    [
        (changed("stiffness", lambda A: A[:, :-1]), "'stiffness' is not square"),
        (changed("mass", lambda A: A[:-1, :-1]), "'mass' has 12 rows, 'stiffness' 13"),
        (changed("stiffness", entry(0, 6, -251.0)), "'stiffness' is not symmetric: entries (1, 7) and (7, 1) are -251"),
        (changed("mass", entry(12, 12, -1.0)), "'mass' is not positive semi-definite"),
        (changed("mass", entry(0, 0, 9.0)), "'mass' is not the same along x, y and z: 10.5, 3, 3; expected are disp"),
        (changed("stiffness", entry(0, 0, 300.0)), "'stiffness' resists a rigid translation along x; expected"),
        (changed("positions", lambda X: 0.9 * X), "'stiffness' resists a rigid rotation along"),
        (changed("mass", lambda A: 0.0 * A), "'mass' has no mass in rigid translations"),
        (changed("stiffness", lambda A: A[:6, :6]), "need 12"),
        (changed("stiffness", entry(0, 0, np.nan)), "has numbers that are not finite"),
        (changed("positions", lambda X: X[:, :2]), "'positions' must have 3 columns, has 2"),
        (bar() | {"masses": np.eye(3)}, "has an unknown key 'masses'"),
        ({key: bar()[key] for key in ("positions", "stiffness")}, "has no 'mass'"),
        (bar() | {"interior_names": np.array(["m"])}, "belong together"),
        (bar() | {"lines": np.array([[0.0, 2.0]])}, "'lines' must be pairs of node numbers, 0 to 1"),
        (bar() | {"damping": -np.eye(13)}, "'damping' is not positive semi-definite"),
    ],
)  # fmt: skip
def test_errors_in_a_file_of_matrices(tmp_path, content, text):
    if text == "need 12":
        content["mass"] = content["mass"][:6, :6]
    with pytest.raises(DeckError) as info:
        read(tmp_path, content)
    (problem,) = info.value.problems
    assert problem.message.startswith("superelement 'arm': ") and text in problem.message
    assert problem.mark.line == 8


@pytest.mark.parametrize(
    ("old", "new", "text"),
    [
        ("FILE", "none.npz", "file 'none.npz' cannot be read: No such file or directory"),
        ("FILE", "../arm.npz", "must lie in the folder of the deck"),
        ("FILE", "arm.mat", "must be a .yaml, .npz or .h5 file"),
        ("FILE", "text.npz", "file 'text.npz' cannot be read as .npz"),
        ("FILE", "text.h5", "file 'text.h5' cannot be read as .h5"),
        ("FILE", "folder.npz", "it is not a regular file"),
        ("FILE", "{positions: [[0, 0, 0]], stiffness: K.csv, mass: [[1]]}", "must be .mtx (Matrix Market) or .npy"),
        ("[1, 2, 0]", "[1, 2.1, 0]", "'nodes': number 2 is 0.1 m from its position in the superelement"),
        (", orientation: [0, 0, 1.5707963267948966]", "", "whose axes are those of the first node"),
        ("[1, 2, 0]", "[1, 0.002, 0]", "times as large as the model: are its file and matrices in mm, not in SI"),
        ("nodes: [a, b]", "nodes: [a, b, c]", "unknown node 'c'"),
    ],
)
def test_files_and_nodes_that_cannot_be(tmp_path, old, new, text):
    for name in ("text.npz", "text.h5"):
        (tmp_path / name).write_text("no archive")
    (tmp_path / "folder.npz").mkdir()
    with pytest.raises(DeckError) as info:
        read(tmp_path, bar(), DECK.replace(old, new))
    assert text in info.value.problems[0].message


def test_a_file_of_nastran_is_to_be_imported(tmp_path):
    (tmp_path / "arm.pch").write_text("GRID*  1\n")
    with pytest.raises(DeckError) as error:
        deck_of_bytes(DECK.replace("FILE", "arm.pch").encode(), str(tmp_path / "deck.yaml"))
    (problem,) = error.value.problems
    assert problem.message.endswith("file 'arm.pch' is one of Nastran")
    assert problem.hint == "`mecano import arm.pch` converts it"
