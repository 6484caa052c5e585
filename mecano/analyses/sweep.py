"""Modes over one or two parameters of a deck: root loci, critical values, maps of stability."""

import os
import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from mecano.analyses.friction_and_play import friction_and_play_warnings
from mecano.analyses.modal import largest_motions
from mecano.analyses.operating_point import angular_velocity_of, operating_point
from mecano.analyses.small_motion_warnings import (
    STEADY,
    accuracy_warnings,
    imbalance_warnings,
    noticed,
    slow_mode_warnings,
    slowest,
)
from mecano.analyses.source import source_of
from mecano.analyses.sweep_axis import NUMBER, Axis
from mecano.analyses.sweep_contents import contents
from mecano.analyses.sweep_text import lines
from mecano.deck.deck import Deck
from mecano.deck.read import read_deck
from mecano.deck.unit_of import unit_of, written_parameters
from mecano.deck.wording import suggestion
from mecano.errors import AssemblyError, ConvergenceError, NonFiniteError, UsageError
from mecano.process.interrupt import call_interruptibly
from mecano.results.file_names import to_be_written
from mecano.results.sweep_file import refuse_tables, write_sweep, write_tables
from mecano.solve.modal.critical import Critical, branch_end, critical
from mecano.solve.modal.families import FAMILIES, families, running_axes
from mecano.solve.modal.linearize import linearize
from mecano.solve.modal.modes import solve, unstable
from mecano.solve.modal.tracking import Spectrum, growing, least_damped, loci, track
from mecano.solve.modal.whirl import Resonance, resonances, whirling

ALONE = re.compile(rf"(?<!\w){NUMBER}")  # not within a name
MOTIONS = re.compile(r"(?:node '[^']*' (?:turns|moves) [^;]*(?:; )?)+")  # the largest motions of a mode
Settings: TypeAlias = tuple[tuple[str, float], ...]  # paths of numbers in the deck, and their values
Describe: TypeAlias = "Callable[[complex, np.ndarray], str]"  # the largest motions of a mode, in words
FAILED = (AssemblyError, ConvergenceError, NonFiniteError)  # the sweep continues without a state that raises these


@dataclass
class Locus:
    """A sweep over one parameter: branches of eigenvalues and the critical values between them."""

    axis: Axis
    values: np.ndarray  # (branches, n) complex, imaginary parts not negative; nan where a branch has none
    motions: list[str]  # (branches,) largest motions of the mode where it is least damped
    families: np.ndarray  # (branches, n) indices into FAMILIES of families.py; -1 where a branch has none
    converged: np.ndarray  # (branches, n) bool; True where a branch has none
    critical: list[Critical]
    unrefined: list[str]  # modes that become unstable or stable between two values, with the cause
    growth: np.ndarray  # (n,) largest real part [1/s] of the eigenvalues above ``least``; nan where no state was found
    count: np.ndarray  # (n,) number of growing modes; -1 where no state was found
    fastest: np.ndarray  # (n,) complex: the eigenvalue with the largest real part
    swinging: np.ndarray  # (n,) complex: that of the eigenvalues that oscillate; nan where none does
    least: np.ndarray  # (n,) [1/s]: smaller eigenvalues cannot be distinguished from zero
    variation: np.ndarray  # (n,) variation of the Linearization; 0 where no state was found
    whirl: np.ndarray | None = None  # (branches, n) see whirl.py, nan where a branch has none; None without a rotor
    speed: np.ndarray | None = None  # (n,) [rad/s] of the rotor; nan where no state was found
    resonances: Sequence[Resonance] = ()

    @property
    def family_names(self) -> list[list[str]]:
        """Lists (branches, n) of names of the families of the modes, "" where a branch has none."""
        return [["" if number < 0 else FAMILIES[number] for number in row] for row in self.families]

    def of_instant(self, found: Critical) -> bool:
        """Return whether a Critical lies between states that are not steady, so that its modes hold for an instant."""
        i = int(np.searchsorted(self.axis.values, found.place))
        return bool(self.variation[max(i - 1, 0) : i + 1].max() > STEADY)


@dataclass
class Sweep:
    """Result of a sweep: a Locus for each value of the second axis, or a single one."""

    axes: tuple[Axis, ...]
    loci: list[Locus]
    warnings: list[str]
    about: str
    deck: Deck  # the checked deck without the values of the sweep
    rotor: str = ""  # node whose speed a Campbell diagram shows
    orders: tuple[float, ...] = ()  # multiples of its speed


@dataclass
class Case:
    """The deck of a sweep and the options of its modes; collects warnings and errors of the states."""

    path: str
    overrides: tuple[str, ...] = ()
    number: int = 1_000_000
    frame: str = "inertial"
    method: str = "automatic"
    rotor: str = ""
    warnings: dict[str, tuple[str, set[Settings]]] = field(default_factory=dict)
    """text without numbers and motions -> (first text, settings of the states that have it)"""
    about: str = ""
    error: Exception | None = None  # of the last state that was not found
    variation: float = 0.0  # of the Linearizations, largest of all states
    residuals: dict[Settings, float] = field(default_factory=dict)  # settings -> largest of all modes but free ones
    units: dict[str, str] = field(default_factory=dict)  # path -> SI unit of its values, "" for numbers without units

    def deck(self, settings: Settings = ()) -> Deck:
        """Return the checked deck with ``settings``, pairs (path, value), applied."""
        values = (f"{path}={value!r} {self.units.get(path, '')}".rstrip() for path, value in settings)
        return read_deck(self.path, (*self.overrides, *values))

    def warn(self, text: str, settings: Settings) -> None:
        """Record a warning about the state with ``settings``.

        Texts that differ only in numbers, or in the nodes that move most, count as one warning.
        """
        alike = ALONE.sub("#", MOTIONS.sub("motions", text))
        self.warnings.setdefault(alike, (text, set()))[1].add(settings)

    def fail(self, error: Exception, settings: Settings) -> None:
        """Record the error of a state."""
        self.error = error
        self.warn(_first_line(error), settings)

    def counted_warnings(self, states: set[Settings]) -> list[str]:
        """Return the warnings, each with the number of its ``states`` (a set of settings) unless it applies to all."""
        counted = [(text, len(found & states)) for text, found in self.warnings.values()]
        return [text if count == len(states) else f"{text} ({_share(count)})" for text, count in counted]

    def spectrum(self, settings: Settings) -> tuple[Spectrum, Describe, float]:
        """Return (Spectrum, function of a mode that describes its motion, variation) of a state."""
        deck = self.deck(settings)
        base = operating_point(deck)
        prepared, system = base.prepared, base.prepared.system
        turning = angular_velocity_of(system, base.state, self.frame)
        lin = linearize(system, base.state, prepared.length, turning, base.assemble, prepared.stiff_compliance)
        found = call_interruptibly(solve, lin, self.number, self.method)
        self.about = base.words.partition(" at [")[0]
        self.variation = max(self.variation, noticed(lin, slowest(found.values)))
        self.residuals[settings] = float(found.residuals[found.values != 0.0].max(initial=0.0))
        for text in (
            *base.warnings,
            *imbalance_warnings(base, turning),
            *friction_and_play_warnings(deck, system, base.state),
            *slow_mode_warnings(lin, found.values),
        ):
            self.warn(text, settings)

        def motion(value, shape):
            return largest_motions(system, base.state, lin, value, shape / lin.root)

        whirl, omega = None, np.zeros(3)
        if self.rotor:
            omega = angular_velocity_of(system, base.state, self.rotor)
            found, whirl = whirling(found, lin, system.numbering, omega)
        of = families(lin, system.numbering.kind[: system.n_q], running_axes(system, base.state), found.shapes)
        speed = float(np.linalg.norm(omega))
        return Spectrum.of(found, lin.root, lin.pace, of, whirl, speed), motion, lin.variation


def sweep(
    path: str,
    overrides: Iterable[str],
    texts: Sequence[str],
    *,
    number: int | None = None,
    frame: str = "inertial",
    method: str = "automatic",
    rotor: str = "",
    orders: Sequence[float] = (1.0,),
    progress: Callable[[int, int, str], object] = lambda *_: None,
) -> Sweep:
    """Compute the modes of a deck file over one or two ``texts`` "parameter=from:to:step", and return a Sweep.

    ``rotor``: the node of a rotor, whose angular velocity, multiplied by ``orders``, is compared with the frequencies
    (Campbell diagram). ``progress(done, total, text)`` is called for every state. Values at which no state is found are
    omitted, with a warning. Raises UsageError, DeckError, and the error of the last state if there is none at any
    value.
    """
    case = Case(path, tuple(overrides), number or 1_000_000, frame, method, rotor)
    deck = case.deck()
    _check_rotor(rotor, deck, texts)
    if len(texts) > 2:
        raise UsageError("--sweep may be given once, or twice for a map of stability")
    axes = tuple(Axis.parse(text, deck.values["parameters"]) for text in texts)
    if len(axes) == 2 and axes[0].path == axes[1].path:
        raise UsageError(f"both sweeps are over '{axes[0].name}'")
    case.units = {axis.path: axis.unit for axis in axes}
    axes = _with_units(axes, deck)
    others = [()] if len(axes) == 1 else [((axes[1].path, float(value)),) for value in axes[1].values]
    first, total = axes[0], len(axes[0].values) * len(others)
    found = []
    for i, other in enumerate(others):
        reported = lambda done, text, i=i: progress(i * len(first.values) + done, total, text)  # noqa: E731
        found.append(_locus(case, first, other, reported, orders if rotor else ()))
    if case.error is not None and all(np.all(locus.count < 0) for locus in found):
        raise case.error
    states = {(*other, (first.path, float(value))) for other in others for value in first.values}
    residuals = [case.residuals[state] for state in states if state in case.residuals]
    warnings = [*case.counted_warnings(states), *accuracy_warnings(case.variation, residuals)]
    return Sweep(axes, found, warnings, case.about, deck, rotor, tuple(orders) if rotor else ())


def _with_units(axes, deck):
    """Return the axes with the units that the deck gives to their values, if they are written without one."""
    written = written_parameters(deck)
    return tuple(replace(a, unit=a.unit or unit_of(a.path, deck.values, [written.get(a.path)])) for a in axes)


def _check_rotor(rotor, deck, texts):
    """Raise UsageError if the deck has no node ``rotor``, or two parameters vary."""
    if not rotor:
        return
    if rotor not in deck.values["nodes"]:
        hint = suggestion(rotor, deck.values["nodes"])
        raise UsageError(f"--campbell: the deck has no node '{rotor}'" + (f"; {hint}" if hint else ""))
    if len(texts) > 1:
        raise UsageError("--campbell takes one --sweep, over the speed of the rotor")


def _share(count):
    return f"in {count} of the states" if count else "between the states, near critical values"


def _locus(case, axis, other, reported, orders):
    """Return the Locus over ``axis`` with the settings ``other``; ``orders`` of a Campbell diagram."""
    spectra, motions, variations = [], [], []
    for i, value in enumerate(axis.values):
        settings = (*other, (axis.path, float(value)))
        try:
            spectrum, motion, variation = case.spectrum(settings)
        except FAILED as error:
            spectrum, motion, variation = None, None, 0.0
            case.fail(error, settings)
        spectra.append(spectrum)
        motions.append(motion)
        variations.append(variation)
        reported(i + 1, ", ".join(f"{path.removeprefix('parameters.')} {value:.6g}" for path, value in settings))
    values, rows, shown = loci(track(spectra, axis.values), spectra)
    described = [_described(row, spectra, motions) for row in shown]
    spectrum_at = lambda value: case.spectrum((*other, (axis.path, float(value))))[0]  # noqa: E731
    growth, count, fastest, swings = _growth(spectra)
    found, unrefined = _criticals(axis, rows, spectra, spectrum_at)
    unrefined += _unseen(axis, count, rows, spectra)
    least = np.array([spectrum.least if spectrum else 0.0 for spectrum in spectra])
    kinds = _by_branch(shown, spectra, "families", -1)
    sure = _by_branch(shown, spectra, "converged", True)
    locus = Locus(
        axis, values, described, kinds, sure, found, unrefined, growth, count, fastest, swings, least,
        np.array(variations),
    )  # fmt: skip
    if case.rotor:
        locus.whirl = _by_branch(shown, spectra, "whirl", np.nan)
        locus.speed = np.array([spectrum.speed if spectrum else np.nan for spectrum in spectra])
        locus.resonances, missed = resonances(shown, spectra, axis.values, orders, spectrum_at)
        unrefined += [_not_refined_text(case.rotor, axis, *one) for one in missed]
    return locus


def _not_refined_text(rotor, axis, branch, order, low, high):
    """Return the text on a resonance that was not refined."""
    between = f"between {axis.name} {low / axis.size:.9g} and {high / axis.size:.9g}"
    return f"mode {branch + 1} has {order:g} times the speed of '{rotor}' {between}; its value was not refined"


def _by_branch(rows, spectra, name, none):
    """Return the attribute ``name`` of each mode of branches, shaped as ``rows``; ``none`` where one has no mode."""
    own = [[getattr(spectra[i], name)[mode] if mode >= 0 else none for i, mode in enumerate(row)] for row in rows]
    return np.array(own).reshape(rows.shape)


def _described(row, spectra, motions):
    """Return a description of the largest motions of a branch, where it is least damped."""
    values = np.array([spectra[i].values[mode] if mode >= 0 else np.nan for i, mode in enumerate(row)])
    i = least_damped(values, np.array([spectrum.least if spectrum else 0.0 for spectrum in spectra]))
    return motions[i](values[i], spectra[i].shapes[row[i]])


def _growth(spectra):
    """Return, for each spectrum, the largest real part, the number of growing modes, and the fastest eigenvalues.

    These are the one of all, and the one of oscillations.
    """
    growth, count = np.full(len(spectra), np.nan), np.full(len(spectra), -1)
    fastest, swings = (np.full(len(spectra), np.nan, complex) for _ in range(2))
    for i, spectrum in enumerate(spectra):
        if spectrum is None:
            continue
        growth[i], count[i], fastest[i] = 0.0, 0, 0.0
        values = spectrum.counting
        if len(values):
            fastest[i] = values[np.argmax(values.real)]
            growth[i], count[i] = fastest[i].real, int(np.sum(unstable(values)))
        if np.any(values.imag):
            swings[i] = max(values[values.imag > 0.0], key=lambda value: value.real)
    return growth, count, fastest, swings


def _criticals(axis, rows, spectra, spectrum_at):
    """Return the Criticals at which branches become unstable or stable, sorted by value, and ``Locus.unrefined``."""
    found, unrefined, place = [], [], np.nan

    def noted(value):
        nonlocal place
        place = float(value)
        return spectrum_at(place)

    for branch, row in enumerate(rows):
        grows = growing(row, spectra)
        for i in np.flatnonzero(_crosses(row, grows)).tolist():
            left, right = (branch_end(spectra, axis.values, row, j) for j in (i, i + 1))
            at, cause = None, "the mode could not be followed from one to the other"
            try:
                at = critical(noted, left, right, branch)
            except FAILED as error:
                cause = f"no state was found at {place / axis.size:.9g}: {_first_line(error)}"
            if at is not None:
                found.append(at)
                continue
            becomes = f"mode {branch + 1} becomes {'unstable' if grows[i + 1] else 'stable'}"
            between = f"between {axis.name} {left[0] / axis.size:.9g} and {right[0] / axis.size:.9g}"
            unrefined.append(f"{becomes} {between}; the critical value was not refined, because {cause}")
    return _distinct(sorted(found, key=lambda c: c.place)), unrefined


def _crosses(row, grows):
    """Return whether a branch that ``grows`` (n,) becomes unstable or stable in each interval (n - 1,)."""
    return (row[:-1] >= 0) & (row[1:] >= 0) & np.diff(grows)


def _unseen(axis, count, rows, spectra):
    """Yield a text for each interval at one end of which alone modes grow, although no branch crosses it.

    A mode that has no stiffness at the other end is a free motion there, and no branch leads to it.
    """
    crossed = np.any([_crosses(row, growing(row, spectra)) for row in rows], axis=0)
    borders = (count[:-1] >= 0) & (count[1:] >= 0) & np.diff(count > 0) & ~crossed
    for i in np.flatnonzero(borders).tolist():
        what = f"growth {'begins' if count[i + 1] else 'ends'}"
        low, high = axis.values[i : i + 2] / axis.size
        between = f"between {axis.name} {low:.9g} and {high:.9g}"
        cause = "no mode has a branch at both: shift the values of the sweep a little"
        yield f"{what} {between}; the critical value was not refined, because {cause}"


def _first_line(error):
    """Return the first line of an error, without a phrase that introduces the next lines."""
    line = str(error).partition("\n")[0]
    return line.rpartition("; ")[0] or line.rstrip(":") if line.endswith(":") else line


def _distinct(criticals):
    """Return the Criticals without duplicates from two branches that meet as a pair."""
    kept: list[Critical] = []
    for c in criticals:
        twin = any(abs(c.place - k.place) <= 1e-9 * abs(c.place) and c.destabilizes == k.destabilizes for k in kept)
        if not twin or c.value.imag != 0.0 and not any(abs(c.value - k.value) < 1e-6 * abs(c.value) for k in kept):
            kept.append(c)
    return kept


def sweep_into(
    file: str | os.PathLike[str],
    path: str,
    overrides: Iterable[str],
    texts: Sequence[str],
    *,
    columns: bool = False,
    force: bool = False,
    **options: Any,
) -> tuple[str, int]:
    """Write a ``sweep`` to a file, with ``columns`` also to CSV tables next to it; return (text, number of states).

    Raises the errors of ``sweep``, and ResultsError if one of the files exists, unless ``force``, or cannot be written.
    """
    tables = Path(file).with_suffix(".csv")
    with to_be_written(file, force, "--csv also writes the numbers"):
        if columns:
            refuse_tables(tables, force)
        found = sweep(path, overrides, texts, **options)
        deck, plain = found.deck, contents(found)
        warnings = [*found.warnings, *(text for locus in found.loci for text in locus.unrefined)]
        write_sweep(file, plain, source_of(deck, warnings=warnings), force=force)
        if columns:
            write_tables(tables, plain, force)
    text = "\n".join([*lines(found), *(f"mecano: {text}" for text in found.warnings)])
    return text, sum(len(locus.count) for locus in found.loci)
