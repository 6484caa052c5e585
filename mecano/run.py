"""One run, from the deck to the results file: read, build, start, march, close."""

from dataclasses import dataclass

import numpy as np

from mecano.deck.build import build, set_velocities, time_breakpoints
from mecano.errors import AssemblyError
from mecano.model.sampler import Sampler
from mecano.model.system import System
from mecano.results.layout import Layout, Series
from mecano.results.provenance import Source
from mecano.results.writer import Writer
from mecano.solve.analysis import analyse
from mecano.solve.generalized_alpha import Coefficients, GeneralizedAlpha
from mecano.solve.initial import assemble_positions
from mecano.solve.interpolate import interpolate
from mecano.solve.linear import LinearSolver
from mecano.solve.march import March
from mecano.solve.scales import Tolerances, compliance, length_scale
from mecano.solve.step_control import AdaptiveStep, FixedStep

METHODS = {
    "generalized_alpha": Coefficients.generalized_alpha,
    "hht": Coefficients.hht,
    "newmark": Coefficients.newmark,
}
SMALLEST_STEP = 1e-7  # of the first step, where the deck does not say
AUTOMATIC = "automatic"


@dataclass
class Prepared:
    """A model ready to march, with what a user should know before."""

    deck: object
    system: System
    linear: LinearSolver
    length: float  # [m]
    state: object  # State: positions assembled, velocities of the deck
    displacement: float  # [m] by which the assembly moved the deck's positions at most
    analysis: object  # redundant constraints and mechanisms
    compliance: object  # None or (n_l,)


def prepare(deck):
    """Build the model of a checked deck and assemble its positions; raises AssemblyError."""
    system = System(build(deck))
    of, values = system.numbering, deck.values["time"]
    linear = LinearSolver(system.n, system.rows, system.cols, of.group, of.n_q)
    length = _given((values["adaptive"] or {}).get("length_scale", AUTOMATIC), length_scale(system.nodes))
    state, displacement = assemble_positions(system, linear, system.initial_state(values["start"]), length)
    if problems := system.inadmissible(state):
        raise AssemblyError("the initial positions were assembled the wrong way round:\n  " + "\n  ".join(problems))
    set_velocities(deck, system, state)
    analysis = analyse(system, state, length)
    soft = compliance(system, state, length) if analysis.redundant or not analysis.complete else None
    return Prepared(deck, system, linear, length, state, displacement, analysis, soft)


def march_of(prepared, observers=()):
    """The March of a prepared model, with method and step control as the deck says."""
    deck, system, values = prepared.deck, prepared.system, prepared.deck.values["time"]
    newton, scale = values["newton"], values["scale"]
    tolerances = Tolerances(
        force=newton["force_tolerance"],
        constraint=newton["constraint_tolerance"],
        max_iterations=newton["maximum_iterations"],
    )
    method = GeneralizedAlpha(
        system, prepared.linear, METHODS[values["method"]](values["rho_inf"]), prepared.length, tolerances,
        k=_given(scale["k"], None), penalty=_given(scale["penalty"], None), compliance=prepared.compliance,
    )  # fmt: skip
    return March(system, method, _control(values), tuple(observers), time_breakpoints(deck))


def _control(values):
    step, adaptive = values["step"], values["adaptive"]
    if adaptive is None:
        return FixedStep(step, SMALLEST_STEP * step)
    duration = values["end"] - values["start"]
    return AdaptiveStep(
        adaptive["tolerance"], duration,
        minimum=_given(adaptive["minimum_step"], SMALLEST_STEP * step),
        maximum=_given(adaptive["maximum_step"], duration / 20),
    )  # fmt: skip


def _given(value, otherwise):
    return otherwise if value == AUTOMATIC else value


class Recorder:
    """Observer that writes saved times, solver history, events and extremes."""

    def __init__(self, prepared, writer, sampler):
        self.system, self.writer, self.sampler = prepared.system, writer, sampler
        values = prepared.deck.values
        every = values["output"]["every"]
        self.every = None if every == "step" else every
        self.start, self.end, self.saved = values["time"]["start"], values["time"]["end"], 0

    def first(self, run):
        """Write the start itself."""
        row = self.sampler.take(run)
        self.writer.extremes.take(run.motion.t, row)
        self.writer.append(run.motion.t, row)

    def __call__(self, accepted):
        """Write one accepted step: its line in the history, the saved times it covers, its events."""
        run, info = accepted.run, accepted.info
        if accepted.h:
            row = self.sampler.take(run)
            self.writer.extremes.take(run.motion.t, row)
            numbers = [accepted.h, info.iterations, info.error, accepted.rejected, *info.norms]
            self.writer.append_step(run.motion.t, np.array(numbers, float))
            self._save(accepted, row)
        for happening in accepted.happenings:
            self.writer.append_event(
                happening.t, happening.element, happening.name, happening.before, happening.after
            )  # fmt: skip

    def _save(self, accepted, row):
        """Save the step, or the motion at every multiple of the interval in it: interpolated, never a shortened step."""
        t = accepted.run.motion.t
        if self.every is None:
            self.writer.append(t, row)
            return
        here, sliver = row.copy(), 1e-9 * self.every
        while (wanted := self._next()) <= t + sliver and self.saved >= 0:
            self.writer.append(wanted, here if wanted > t - sliver else self._between(accepted, wanted))
            self.saved = self.saved + 1 if wanted < self.end else -1

    def _between(self, accepted, t):
        state = interpolate(accepted.before, accepted.run.motion, t, self.system.numbering)
        self.system.assemble(state, 1.0, 0.0, 0.0, 0.0, 1.0)
        self.system.observe(state)
        return self.sampler.take(accepted.at(state))

    def _next(self):
        """The next time to be saved; the last one is the end."""
        return min(self.start + (self.saved + 1) * self.every, self.end)


def run(deck, path, *, force=False, observers=(), announce=lambda text: None):
    """Run a checked deck into the results file ``path``; returns the final RunState.

    ``observers`` are told of every accepted step, ``announce`` of what a user should know before the march. Whatever
    stops the run, the file keeps every acknowledged step and says why it ended. Raises AssemblyError (the start),
    ConvergenceError, NonFiniteError (the march), ResultsError (the file).
    """
    prepared = prepare(deck)
    sampler = Sampler(prepared.system)
    layout = Layout([Series(c.path, c.unit, c.doc, c.shape) for c in sampler.columns])
    source = Source(deck.text, deck.resolved(), deck.file, deck.values["title"], deck.overrides, deck.files)
    with Writer.create(path, layout, source, force=force) as writer:
        for text in remarks(prepared):
            announce(text)
        recorder = Recorder(prepared, writer, sampler)
        march = march_of(prepared, (recorder, *observers))
        start = march.begin(prepared.state, deck.values["time"]["step"])
        recorder.first(start)
        return march.to(deck.values["time"]["end"], start)


def remarks(prepared):
    """What a user should know of a model before it runs, one text each."""
    texts, analysis = [], prepared.analysis
    if prepared.displacement > 1e-6 * prepared.length:
        texts.append(f"the assembly moved the initial positions by up to {prepared.displacement:.3g} m")
    for group in analysis.redundant:
        texts.append(
            f"{group.count} redundant constraint(s) among: {'; '.join(group.names)}. The motion is not affected; the "
            "reactions of these constraints are not unique"
        )
    if not analysis.complete:
        texts.append("too many constraints in closed loops to be analysed for redundancy; the run allows for it")
    return texts
