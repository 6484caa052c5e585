"""Kinds, tyre laws and laws of one's own: docs/plugins.md as it stands, `mecano check-kind`, what is recorded."""

import doctest
import hashlib
import json
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from process import COMMAND, mecano_process
from scipy.integrate import solve_ivp

import mecano
from mecano.analyses.plugin_check import check_compilation
from mecano.element_interface import Kind
from mecano.errors import CompilationError
from mecano.interface import plugins
from mecano.jit.compilation_error import compilation_errors
from mecano.jit.kernel import kernel

PAGE = (Path(__file__).parent.parent / "docs" / "plugins.md").read_text(encoding="utf-8")
SOURCES = dict(re.findall(r"`(my_\w+\.py)`[^`]*?:\n\n```python\n(.*?)```", PAGE, re.DOTALL))
[FALL] = re.findall(r"`fall.yaml`:\n\n```yaml\n(.*?)```", PAGE, re.DOTALL)
[TYRE] = re.findall(r"```yaml\n(tire_laws:\n.*?)```", PAGE, re.DOTALL)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A working folder with the files of the page."""
    for name, text in {**SOURCES, "fall.yaml": FALL}.items():
        (tmp_path / name).write_text(text)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def call(*words, **environment):
    """Exit code, standard output and errors of `mecano`, in a process of its own: plugins stay in a process."""
    code, out, errors = mecano_process(*words, **environment)
    assert "Traceback" not in errors, errors
    return code, out, errors


def test_the_files_of_the_page_are_short():
    assert set(SOURCES) == {"my_drag.py", "my_hysteresis.py", "my_tyre.py", "my_joint.py", "my_law.py"}
    assert len([line for line in SOURCES["my_drag.py"].splitlines() if line.strip()]) <= 30
    assert max(len(text.splitlines()) for text in SOURCES.values()) <= 48


@pytest.mark.parametrize("name", SOURCES)
def test_the_files_of_the_page_pass_the_generic_tests(folder, name):
    code, out, _ = call("check-kind", name)
    assert code == 0 and "passed" in out and "FAILED" not in out, out
    assert (name != "my_drag.py") or "passed  Tangents are the derivatives of the force" in out


@pytest.mark.parametrize(
    ("old", "new", "failed"),
    [
        ("e[2] = y[0]", "e[2] = 2.0 * y[0]", "The power of the forces is the change of energy"),
        ("e[2] = y[0]", "e[2] = -y[0]", "The power of the forces is the change of energy"),
        ("norm(v), v)", "(1.0 + v[2]), v)", "Forces rotate with the whole model"),
        ('"-", "node on which', '"", "node on which', "Fields, outputs, rows and events are declared"),
        ('"force", "N",', '"force", "Nm",', "Fields, outputs, rows and events are declared"),
        ('"force", "N",', '"force", "kN",', "Fields, outputs, rows and events are declared"),
        (
            "    observe=observe,",
            "    observe=observe, phases=('one', 'two'), sample=lambda rng: [({'coefficient': 1.0}, 1, 'one')],",
            "Samples pass the check",
        ),
    ],
)
def test_what_is_wrong_in_a_kind_is_found(folder, old, new, failed):
    text = SOURCES["my_drag.py"]
    assert text.count(old) == 1
    (folder / "my_drag.py").write_text(text.replace(old, new))
    code, out, err = call("check-kind", "my_drag.py")
    assert code == 2 and f"FAILED  {failed}" in out and "of my_drag.py failed" in err
    assert ("e[2]" not in old) or re.search(r"f\.v = \d.* W, but d\(T \+ V\)/dt = 0 W, dissipated = e\[2\] = ", out)


@pytest.mark.parametrize(
    ("wrong", "said"),
    [("at.x", "'Place' object has no attribute 'x'; known: t, phase, "), ("other.v", "name 'other' is not defined")],
)
def test_an_exception_has_the_line_of_the_plugin(folder, wrong, said):
    text = SOURCES["my_drag.py"].replace("vec(at.v, 0)", f"vec({wrong}, 0)", 1)
    (folder / "my_drag.py").write_text(text)
    line = text[: text.index(wrong)].count("\n") + 1
    code, out, _ = call("check-kind", "my_drag.py")
    assert code == 2 and f"line {line}: " in out and said in out


KEEL = """
from mecano.element_interface import Kind, Output
from mecano.jit.kernel import kernel
from mecano.maths.vector import add_vec, dot, mat, vec
from mecano.schema import NODE, NODE_VECTOR, VECTOR, Field

@kernel
def residual(p, at, f):
    axis = mat(at.R[0]) @ vec(p.axis, 0)
    add_vec(f, 0, dot(axis, vec(at.v, 0)), axis)

@kernel
def observe(p, at, F, y, e):
    axis = mat(at.R[0]) @ vec(p.axis, 0)
    y[0] = dot(axis, vec(at.v, 0))
    e[2] = y[0] * y[0]

KEEL = Kind(name="keel", section="loads", doc="Drag along an axis of a node.", layout=("x0", "R0"),
    fields=(Field("node", NODE, "-", "node"), Field("axis", NODE_VECTOR, "-", "axis, in the axes of the node")),
    outputs=(Output("drag", "N", "drag"),), residual=residual, observe=observe)
"""


def test_a_vector_in_the_axes_of_a_node_is_not_inertial(folder):
    """With the type of an inertial vector it is turned with the model, once too often."""
    for of_field, code in (("NODE_VECTOR, ", 0), ("VECTOR, ", 2)):
        (folder / "keel.py").write_text(KEEL.replace('"axis", NODE_VECTOR, ', f'"axis", {of_field}'))
        found, out, _ = call("check-kind", "keel.py")
        assert found == code, out
        assert ("'axis' is VECTOR, in inertial axes; NODE_VECTOR is a vector in the axes of the node" in out) == bool(
            code
        )


@pytest.mark.parametrize("raw", ["at.R[0] @ vec(p.axis, 0)", "vec(at.R[0] @ p.axis, 0)"])
def test_matrices_that_are_not_compiled_are_found(folder, raw):
    """Python multiplies arrays as it does matrices, compiled code does not; the place is that in the plugin."""
    (folder / "keel.py").write_text(KEEL.replace("mat(at.R[0]) @ vec(p.axis, 0)", raw))
    code, out, _ = call("check-kind", "keel.py")
    [reason] = re.findall(r"FAILED  Functions can be compiled\n +(.*)", out)
    assert code == 2 and reason.endswith("are mat(at.R[0]) and vec(p.axis, 0), of mecano.maths.vector")
    assert reason.startswith(f"{folder / 'keel.py'}:9: a kernel cannot be compiled: ")


def test_an_error_of_the_compiler_does_not_chain_its_stages(tmp_path):
    """A traceback of Python is as long as that of any other error of mecano."""
    from numba import njit, types

    with pytest.raises(CompilationError) as error, compilation_errors():
        njit((types.float64,))(lambda x: x + "a")
    assert error.value.__suppress_context__ and error.value.__cause__ is None


def test_a_section_that_decks_lack_is_named(folder):
    (folder / "my_drag.py").write_text(SOURCES["my_drag.py"].replace('section="loads"', 'section="load"'))
    code, _, err = call("check-kind", "my_drag.py")
    assert code == 2 and "the kind 'air_drag' has the section 'load'; known: elements, joints, loads" in err


def test_a_wrong_tangent_by_hand_is_found(folder):
    by_hand = (
        SOURCES["my_drag.py"]
        .replace("def residual(p, at, f):", "def force(p, at, f, K, C, M):")
        .replace("residual=residual", "force=force")
    )
    (folder / "my_drag.py").write_text(by_hand)
    code, out, _ = call("check-kind", "my_drag.py")
    assert code == 2 and "FAILED  Tangents are the derivatives of the force" in out


@pytest.mark.parametrize(
    ("name", "old", "new", "failed"),
    [
        ("my_tyre.py", "-dot(F, k.v), 0.0", "-0.5 * dot(F, k.v), 0.0", "The power of force and moment"),
        ("my_tyre.py", "F = -(share * c)", "F = (share * c)", "The power of force and moment"),
        ("my_law.py", "-2.0 * x * y * y / w", "2.0 * x * y * y / w", "The derivatives of the term"),
        ("my_law.py", "a[i] * math.atan", "math.atan", "The integral of the term"),
    ],
)
def test_what_is_wrong_in_a_law_is_found(folder, name, old, new, failed):
    assert SOURCES[name].count(old) == 1
    (folder / name).write_text(SOURCES[name].replace(old, new))
    code, out, _ = call("check-kind", name)
    assert code == 2 and f"FAILED  {failed}" in out


def test_a_run_with_a_plugin(folder):
    """The speed of the fall is V tanh(g t/V), as the page says; the plugin is recorded; without it there is no run."""
    code, _, err = call("run", "fall.yaml")
    assert code == 2 and "unknown type 'air_drag'" in err
    code, _, err = call("run", "fall.yaml", "--plugin", "my_drag.py", "-q")
    assert code == 0, err
    with mecano.open_results("fall.h5") as results:
        V = np.sqrt(2.0 * 9.81 / 0.05)
        speed = -results["ball.velocity.z"].values
        np.testing.assert_allclose(speed, V * np.tanh(9.81 * results.time / V), atol=2e-4)
        assert speed[-1] == pytest.approx(19.07, abs=0.005) and V == pytest.approx(19.81, abs=0.005)
        np.testing.assert_allclose(results["air.force"].values, 0.05 * speed**2, rtol=1e-12)
        recorded = json.loads(results.metadata["plugins"])
    digest = hashlib.sha256((folder / "my_drag.py").read_bytes()).hexdigest()
    assert recorded == {str(folder / "my_drag.py"): {"sha256": digest, "names": ["air_drag"]}}
    assert re.search(r"plugins +\S+my_drag.py\s+\(air_drag;", call("info", "fall.h5")[1])


HYSTERESIS = """
    mecano: 1
    gravity: none
    nodes: {wall: {position: [-1, 0, 0], fixed: true}, body: {position: [0, 0, 0]}}
    elements:
      mass: {type: point_mass, node: body, mass: 10}
      yielding: {type: hysteresis, nodes: [wall, body], stiffness: 2000, beta: 30, gamma: 20, n: 1.5}
    loads: {shaking: {type: force, node: body, direction: [1, 0, 0], value: 120*sin(9*time)}}
    time: {end: 1, step: 1 ms}
    """


def test_an_element_with_a_state(folder):
    """Its motion is that of its equations, integrated by SciPy; modes are found about a saved state, which has z."""

    def rates(t, y):
        _, v, z = y
        return [v, (120 * np.sin(9 * t) - 2000 * z) / 10, v - abs(z) ** 0.5 * (30 * abs(v) * z + 20 * v * abs(z))]

    (folder / "yielding.yaml").write_text(HYSTERESIS)
    plugin = "--plugin", "my_hysteresis.py"
    assert call("run", "yielding.yaml", "-q", *plugin)[0] == 0
    with mecano.open_results("yielding.h5") as results:
        expected = solve_ivp(rates, (0, 1), [0, 0, 0], t_eval=results.time, rtol=1e-9, atol=1e-11).y
        np.testing.assert_allclose(results["body.position.x"].values, expected[0], atol=2e-5)
        np.testing.assert_allclose(results["yielding.z"].values, expected[2], atol=2e-5)
    code, out, err = call("modes", "yielding.yaml", "--at", "yielding.h5:0.5", *plugin)
    assert code == 0 and "decay" in out, err


def test_an_unknown_that_is_no_output_cannot_be_read(folder):
    source = SOURCES["my_hysteresis.py"].replace('Output("z", "m", "state")', 'Output("inner", "m", "state")')
    (folder / "my_hysteresis.py").write_text(source)
    (folder / "yielding.yaml").write_text(HYSTERESIS.replace("end: 1", "end: 0.01"))
    plugin = "--plugin", "my_hysteresis.py"
    assert call("run", "yielding.yaml", "-q", *plugin)[0] == 0
    code, _, err = call("modes", "yielding.yaml", "--at", "yielding.h5:0.01", *plugin)
    assert code == 5 and "has to declare it among the outputs of 'hysteresis', as 'z'" in " ".join(err.split())


def test_it_is_explained_listed_and_part_of_the_grammar(folder):
    code, out, _ = call("explain", "air_drag", "--plugin", "my_drag.py")
    assert code == 0 and "coefficient [N s2/m2]: a number; required" in out and "force [N]" in out
    assert "Drag of a body in still air" in call("list", "--plugin", "my_drag.py")[1]
    assert '"kind air_drag"' in call("schema", "--plugin", "my_drag.py")[1]
    assert "slip law" in call("explain", "limited", "--plugin", "my_tyre.py")[1]
    assert "bell (term of a law" in call("explain", "bell", "--plugin", "my_law.py")[1]


def test_its_outputs_are_drawn(folder):
    assert call("run", "fall.yaml", "--plugin", "my_drag.py", "-q")[0] == 0
    assert call("post", "fall.h5", "--plugin", "my_drag.py", "-o", "out")[0] == 0
    assert any("loads" in path.name or "drag" in path.name for path in folder.rglob("*.p[nd][gf]"))


def test_a_run_is_resumed_with_the_same_plugin_only(folder):
    run = "run", "fall.yaml", "--plugin", "my_drag.py", "-q"
    assert call(*run)[0] == 0  # compiles
    os.remove("fall.h5")
    assert call(*run, "--set", "time.step=1e-6", "--max-walltime", "3s")[0] == 75 and os.path.exists("fall.h5")
    (folder / "my_drag.py").write_text(SOURCES["my_drag.py"] + "# changed\n")
    code, _, err = call(*run, "--set", "time.step=1e-6", "--resume")
    assert code == 2 and "my_drag.py is missing or was changed" in err


def test_the_cases_of_a_study_get_the_plugins(folder):
    (folder / "study.yaml").write_text(
        "study: 1\ndeck: fall.yaml\nset: {time.end: 0.1}\ngrid: {loads.air.coefficient: [0.05, 0.1, 0.2, 0.5]}\n"
        "outputs: {drag: {of: air.force, take: max}}\n"
    )
    code, _, err = call("sweep", "study.yaml", "--plugin", "my_drag.py", "-q")
    assert code == 0, err
    table = (folder / "study_runs" / "table.csv").read_text()
    assert table.count("complete") == 4


def test_a_tyre_law_and_a_law_in_a_deck(folder):
    deck = (Path(__file__).parent.parent / "inputs" / "fiala_sweep.yaml").read_text()
    deck = deck.replace("tire_law: camber", "tire_law: brush")
    head, _, tail = deck.partition("tire_laws:\n")
    (folder / "own.yaml").write_text(head + TYRE.replace("mine:", "brush:") + tail[tail.index("\ngrounds:") :])
    code, _, err = call("check", "own.yaml", "--plugin", "my_tyre.py")
    assert code == 0, err
    code, _, err = call("check", "own.yaml")
    assert code == 2 and "unknown key 'limited'" in err


def test_wheels_with_a_carcass_are_tested_with_its_law(folder):
    """Also if a field of the law has the name of a value of its carcass."""
    code, out, _ = call("check-kind", "my_tyre.py")
    assert code == 0 and "passed  transient_wheel: Tangents are the derivatives of the force" in out
    text = SOURCES["my_tyre.py"].replace('"carcass_stiffness": [2e3, 3e3]', '"carcass_stiffness": None')
    (folder / "my_tyre.py").write_text(text)
    code, out, _ = call("check-kind", "my_tyre.py")
    assert code == 2 and "FAILED  transient_wheel: Samples pass the check" in out


def test_a_value_of_a_law_named_like_one_of_its_wheels_is_refused(folder):
    text = SOURCES["my_tyre.py"].replace('"stiffness"', '"normal"').replace('"coefficient"', '"spread"')
    (folder / "my_tyre.py").write_text(text)
    code, _, err = call("check-kind", "my_tyre.py")
    assert code == 2 and "the slip law 'limited' has values named normal, spread, as its wheels have" in err


def test_an_installed_package(folder):
    """An entry point of the group mecano.kinds is found without an option; its module is imported."""
    package, info = folder / "site" / "drag_package", folder / "site" / "drag_package-1.0.dist-info"
    package.mkdir(parents=True)
    info.mkdir()
    (package / "__init__.py").write_text("")
    (package / "drag.py").write_text(SOURCES["my_drag.py"])
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: drag-package\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text("[mecano.kinds]\ndrag = drag_package.drag\n")
    path = os.pathsep.join([str(folder / "site"), os.environ.get("PYTHONPATH", "")])
    started = {"env": {**os.environ, "PYTHONPATH": path}, "capture_output": True, "text": True, "check": True}
    assert "coefficient [N s2/m2]" in subprocess.run([*COMMAND, "explain", "air_drag"], **started).stdout
    subprocess.run([*COMMAND, "run", "fall.yaml", "-q"], **started)
    with mecano.open_results("fall.h5") as results:
        assert list(json.loads(results.metadata["plugins"])) == ["drag-package:drag_package.drag"]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("x = 1\ny = (\n", "line 2: SyntaxError"),
        ("x = 1\nimport no_such_module_anywhere\n", "line 2: ModuleNotFoundError: No module named 'no_such"),
        ("x = 1\n", "defines no Kind, SlipLaw or Term"),
        ("import sys\nsys.exit()\n", "line 2: SystemExit"),
        (SOURCES["my_drag.py"].replace('name="air_drag"', 'name="hinge"'), "the kind 'hinge' is already in use"),
    ],
)
def test_a_file_that_cannot_be_used(folder, text, said):
    (folder / "wrong.py").write_text(text)
    for words in (("check-kind", "wrong.py"), ("run", "fall.yaml", "--plugin", "wrong.py")):
        code, _, err = call(*words)
        assert code == 2 and said in err


def test_a_file_that_is_missing():
    assert call("check-kind", "missing.py")[0] == 2


def test_the_example_of_load_plugin(folder, monkeypatch):
    """In a process of its own, too."""
    code = "import doctest, mecano; from mecano.interface import plugins\n"
    code += "print(doctest.testmod(plugins, extraglobs={'mecano': mecano}))"
    assert doctest.DocTestFinder().find(plugins)
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert "failed=0, attempted=1" in ended.stdout, ended.stdout


def test_an_error_of_the_compiler_is_one_line(tmp_path):
    """The innermost place and the reason, without the stages of the compiler."""
    from numba import njit, types

    (tmp_path / "bad.py").write_text("def inner(x):\n    return x + 'a'\n")
    names = {}
    exec(compile((tmp_path / "bad.py").read_text(), tmp_path / "bad.py", "exec"), names)
    inner = njit(names["inner"])
    with pytest.raises(CompilationError) as error, compilation_errors():
        njit((types.float64,))(lambda x: inner(x))
    text = str(error.value)
    assert text.startswith(f"{tmp_path}/bad.py:2: a kernel cannot be compiled: No implementation of function")
    assert "\n" not in text and "During" not in text and "Failed in" not in text


def test_a_kernel_with_an_undefined_name_is_named():
    from numba import njit, types

    def inner(x):
        return x + undefined  # noqa: F821

    called = njit(inner)
    with pytest.raises(CompilationError) as error, compilation_errors():
        njit((types.float64,))(lambda x: called(x))
    assert str(error.value) == "the kernel 'inner' cannot be compiled: name 'undefined' is not defined"


def test_mathematics_of_python_for_several_elements_is_named(tmp_path):
    from numba import njit

    from mecano.jit.lanes import Lanes

    (tmp_path / "bad.py").write_text("import math\ndef inner(x):\n    return math.sqrt(x)\n")
    names = {}
    exec(compile((tmp_path / "bad.py").read_text(), tmp_path / "bad.py", "exec"), names)
    with pytest.raises(CompilationError) as error, compilation_errors():
        njit((Lanes,))(names["inner"])
    text = str(error.value)
    assert text.startswith(f"{tmp_path}/bad.py:3: ") and text.endswith("write those of mecano.maths.dual")


def test_mathematics_of_python_in_a_residual_is_named(folder):
    text = (
        SOURCES["my_drag.py"]
        .replace("norm(v), v)", "math.sqrt(dot(v, v)), v)")
        .replace('"""\n', '"""\nimport math\n', 1)
    )
    (folder / "my_drag.py").write_text(text)
    code, out, _ = call("check-kind", "my_drag.py")
    assert code == 2 and "write those of mecano.maths.dual" in out


def test_a_kind_that_several_elements_cannot_share_is_no_kind():
    given = {"name": "spring", "section": "elements", "doc": "A spring.", "layout": ("x0", "x1"), "by_lanes": True}
    with pytest.raises(ValueError, match="spring: a kind with 'by_lanes' needs 'force', with tangents by hand"):
        Kind(**given, residual=abs, observe=abs)
    with pytest.raises(ValueError, match="'by_lanes' has one phase, no multipliers and no memory"):
        Kind(**given, force=abs, observe=abs, memory=("length",))


def test_a_branch_that_several_elements_cannot_share_is_found():
    @kernel
    def force(p, at, f, K, C, M):
        if at.q[0] > 0.0:
            f[0] += at.q[0]

    @kernel
    def observe(p, at, F, y, e):
        y[0] = at.q[0]

    kind = Kind(name="wall", doc="A wall.", layout=("x0",), by_lanes=True, force=force, observe=observe)
    with pytest.raises(AssertionError, match="branch on everywhere"):
        check_compilation(kind)


def test_an_unknown_field_of_a_record_is_named(tmp_path):
    """Numba itself raises a KeyError without a place."""
    from numba import from_dtype, njit

    (tmp_path / "bad.py").write_text("def inner(p):\n    return p.coeficient\n")
    names = {}
    exec(compile((tmp_path / "bad.py").read_text(), tmp_path / "bad.py", "exec"), names)
    inner, record = njit(names["inner"]), from_dtype(np.dtype([("coefficient", float), ("mass", float)]))
    with pytest.raises(CompilationError) as error, compilation_errors():
        njit((record,))(lambda p: inner(p))
    assert str(error.value) == (
        f"{tmp_path}/bad.py:2: a kernel cannot be compiled: the record p has no field 'coeficient'; "
        "known: coefficient, mass"
    )
