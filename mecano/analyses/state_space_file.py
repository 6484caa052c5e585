"""Export of the linear model of a response as matrices of a state space, for control design: .npz or .mat."""

import io
import os
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from mecano.errors import ConvergenceError, UsageError
from mecano.model.numbering import ROTATION, TRANSLATION
from mecano.results.whole_file import atomic_file, refuse_present
from mecano.solve.modal.frequency_response import TransferFunction
from mecano.solve.modal.state_space import ImproperError, state_space

if TYPE_CHECKING:
    from mecano.analyses.response import Response
    from mecano.model.system import System
    from mecano.solve.modal.frequency_response import Plant

ENDINGS = (".npz", ".mat")
AGREES = 1e-3  # of a transfer function: largest difference of the state space from it
COMPARED = 60  # frequencies
MOST = 3000  # motions, rates and reactions: two minutes and 1 GB
NOISE = 1e-6  # of the largest possible response: least size of a response
SHIFT = 1e-5  # of the frequency: for the slope of the response


def refuse(path: "str | os.PathLike[str]", force: bool) -> None:
    """Raise UsageError for an ending not in ENDINGS, and ResultsError if the file exists, unless ``force``."""
    if Path(path).suffix not in ENDINGS:
        raise UsageError(f"--state-space {os.fspath(path)}: the name of the file must end with {' or '.join(ENDINGS)}")
    refuse_present(path, force)


@dataclass(frozen=True)
class LinearModel:
    """The equations x' = A x + B u, z = C x + D u of small motions; a state "d/dt a" is a rate."""

    A: np.ndarray  # (n, n)
    B: np.ndarray  # (n, m)
    C: np.ndarray  # (p, n)
    D: np.ndarray  # (p, m)
    states: tuple[str, ...]
    state_units: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    difference: float  # of its responses from those of the sparse equations, relative


def linear_model(found: "Response") -> LinearModel:
    """Return the LinearModel of a Response.

    Raises UsageError if there is none, and ConvergenceError if it is not accurate.
    """
    refuse_plant(found.plant)
    try:
        model = state_space(found.plant)
    except ImproperError as error:
        raise UsageError(_improper(found, *error.pairs[0])) from None
    difference = _difference(found, model)
    if not difference <= AGREES:
        raise ConvergenceError(
            f"the state space differs from the response by {difference:.1g}: the response grows with the frequency, or "
            "stiffnesses or masses of the model are too far apart for dense matrices"
        )
    system = found.base.prepared.system
    pairs = zip(model.states.tolist(), model.is_rate.tolist(), strict=True)
    named = [_named(system, i, is_rate) for i, is_rate in pairs]
    states, units = tuple(name for name, _ in named), tuple(unit for _, unit in named)
    return LinearModel(model.A, model.B, model.C, model.D, states, units, found.inputs, found.outputs, difference)


def refuse_plant(plant: "Plant") -> None:
    """Raise UsageError for a Plant with late signals, and for one of more than MOST unknowns and rates."""
    if plant.late:
        raise UsageError(
            "a model with a 'delay' or 'sample_and_hold' has no state space: replace them, such as by a 'lag' or a "
            "'transfer_function' that approximates them"
        )
    number = plant.lin.K.shape[0] + plant.lin.n_q
    if number > MOST:
        raise UsageError(
            "the state space is found from dense matrices of all motions, their rates and reactions, "
            f"{number} here, up to {MOST}: reduce flexible parts to superelements by `mecano reduce`, or give them "
            "fewer elements by 'mesh'; transfer functions have no such limit"
        )


def _improper(found, i, j):
    return (
        f"the response of {found.outputs[i]} to {found.inputs[j]} grows with the frequency, so it has no state space: "
        "take an output of lower order (a velocity for an acceleration, a position for a velocity), or pass the input "
        "through a 'lag'"
    )


def _difference(found, model):
    """Return the largest difference of the responses at COMPARED frequencies, relative to their size.

    Differences that a shift of the frequencies by the same share explains do not count: near an undamped resonance the
    response has fewer digits than its frequency.
    """
    H, worst = TransferFunction(found.plant), 0.0
    chosen = np.linspace(0, len(found.frequency) - 1, COMPARED).astype(int)
    for omega in 2.0 * np.pi * found.frequency[np.unique(chosen)]:
        exact, size = H.with_size(1j * omega)
        shifted = np.abs(H(1j * omega * (1.0 + SHIFT)) - exact) / SHIFT
        if np.isfinite(exact).all() and np.isfinite(shifted).all():
            apart = np.abs(model.C @ model.motion(1j * omega) + model.D - exact)
            worst = max(worst, float(np.max(apart / np.maximum(np.abs(exact) + shifted + NOISE * size, 1e-300))))
    return worst


def _named(system: "System", i: int, is_rate: bool) -> tuple[str, str]:
    """Return the name and the unit of a state: the unknown ``i`` or its rate."""
    name, kind = system.numbering.name[i].motion, system.numbering.kind[i]
    axis = name.what[-1]
    if kind == TRANSLATION:
        text, unit = f"{name.nodes[0]}.position.{axis}", "m"
    elif kind == ROTATION:
        text, unit = f"{name.nodes[0]}.rotation.{axis}", "rad"
    else:
        owner = name.place.split("'")[1] if "'" in name.place else name.place
        text = owner if name.what == "value" else f"{owner}.{name.what}"
        unit = system.signal_units.get(f"signals/{text.replace('.', '/')}", "SI")
        unit = system.signal_units.get(f"signals/{owner}/{name.what}", unit)
    return (f"d/dt {text}", f"{unit}/s") if is_rate else (text, unit)


def write_state_space(path: "str | os.PathLike[str]", found: "Response", model: LinearModel) -> str:
    """Write the matrices A, B, C, D and the names and units of states, inputs, outputs; return a line about it.

    Raises ResultsError.
    """
    contents = {
        "A": model.A, "B": model.B, "C": model.C, "D": model.D, "states": model.states,
        "state_units": model.state_units, "inputs": found.inputs, "input_units": found.input_units,
        "outputs": found.outputs, "output_units": found.output_units,
    }  # fmt: skip
    with atomic_file(Path(path)) as hidden:
        hidden.write_bytes(_mat(contents) if Path(path).suffix == ".mat" else _npz(contents))
    agrees = f"which agrees with the response to {model.difference:.0e}"
    return f"state space of {len(model.states)} states, {agrees}: {os.fspath(path)}"


def _npz(contents):
    data = io.BytesIO()
    arrays: dict[str, Any] = {name: np.array(value) for name, value in contents.items()}
    np.savez(data, **arrays)
    return data.getvalue()


def _mat(contents):
    """Return the bytes of a file of MATLAB; texts are cells."""
    from scipy.io import savemat  # slow to import, and rarely needed

    data = io.BytesIO()
    savemat(data, {k: v if isinstance(v, np.ndarray) else np.array(v, dtype=object) for k, v in contents.items()})
    return data.getvalue()
