"""Ahead-of-time compilation of everything a deck can contain, or of everything that given decks contain."""

import os
import tempfile
from collections.abc import Iterator, Sequence
from importlib import import_module
from pathlib import Path
from pkgutil import walk_packages

from mecano import constraints, elements
from mecano.analyses.compilation import EVENTS, GENERALIZED_ALPHA, TIME_INTEGRATION, divided, radau
from mecano.analyses.dynamic import run
from mecano.analyses.prepare import prepare
from mecano.analyses.static import run as run_static
from mecano.deck.read import deck_of_bytes, read_deck
from mecano.deck.sample_decks import starters
from mecano.element_interface import Kind
from mecano.errors import ResultsError
from mecano.jit import machine_code, store
from mecano.jit.ahead import compile_ahead
from mecano.model.loop_code import all_codes
from mecano.solve.linear import multifrontal
from mecano.solve.time.error_bound import bound_error
from mecano.solve.time.relaxed_error import relax_error

STEPS = 3
BETWEEN = 0.7  # steps between two saved times, which are then interpolated


def warmup(decks: Sequence[str] = (), overrides: Sequence[str] = ()) -> Iterator[str]:
    """Compile the loops of all kinds and the solver, or all code that ``decks`` need; yield progress texts.

    Raises the errors of reading and running a deck.
    """
    if decks:
        for path in decks:
            yield f"running the first steps of {path}"
            _compile_and_step(read_deck(path, (*overrides, *_shortened(read_deck(path, overrides)))))
    else:
        kinds = all_kinds()
        yield f"compiling {len(kinds)} kinds of elements, joints, loads and constraints"
        further = bound_error, relax_error, multifrontal.residual
        entries = *GENERALIZED_ALPHA, *TIME_INTEGRATION, *EVENTS, *further, *radau()
        _compile([*(entry.code for entry in entries), *all_codes(kinds), *divided()])
        yield "running the first steps of the decks of `mecano new`"
        for name, text in starters().items():
            file, data = f"{name}.yaml", text.encode()
            _compile_and_step(deck_of_bytes(data, file, overrides=_shortened(deck_of_bytes(data, file))))
    yield f"compiled code is in {store.folder()}: {store.size() / 1e6:.0f} MB"


def share(folder: str | os.PathLike[str]) -> str:
    """Copy all compiled code of this user into a shared store below ``folder``; return instructions for its users.

    Raises ResultsError if the store cannot be written, or if untrusted users can write there.
    """
    try:
        target, size = store.share(folder)
    except OSError as error:
        raise ResultsError(f"cannot write compiled code to {folder}: {error.strerror or error}") from None
    return (
        f"{size / 1e6:.0f} MB of compiled code are in {target}: let users set {store.SHARED}={Path(folder).absolute()}"
    )


def all_kinds() -> list[Kind]:
    """Return all kinds, including basic constraints and variants."""
    found: dict[int, Kind] = {}
    for package in (constraints, elements):
        for module in walk_packages(package.__path__, f"{package.__name__}."):
            kinds = [value for value in vars(import_module(module.name)).values() if isinstance(value, Kind)]
            found |= {id(kind): kind for kind in kinds}
    return list(found.values())


def _shortened(deck):
    """Return overrides that shorten a dynamic run to some steps, with saved times between them; [] for statics."""
    time = deck.values["time"]
    if not time:
        return []
    end = [f"time.end={time['start'] + STEPS * time['step']!r}"] if _longer(time) else []
    return [*end, f"output.every={BETWEEN * time['step']!r}"]


def _longer(time):
    return time["end"] - time["start"] > STEPS * time["step"]


def _compile(codes):
    """Compile on all cores, then compile the remaining code: all of it on a single core."""
    compile_ahead(codes)
    for code in codes:
        machine_code.address(code)


def _compile_and_step(deck):
    """Compile all loops of the model, including those not called in the first steps, and run some steps."""
    _compile(all_codes(batch.kind for batch in prepare(deck).system.batches))
    with tempfile.TemporaryDirectory() as folder:
        (run_static if deck.values["static"] else run)(deck, os.path.join(folder, "warmup.h5"))
