"""Find and compile the functions that a run needs, before it begins."""

from mecano.jit import machine_code
from mecano.jit.ahead import compile_ahead
from mecano.jit.entry import Entry
from mecano.jit.machine_code import Code
from mecano.model import assembly_driver, extremes, sampler
from mecano.model.system import System
from mecano.schema import Values
from mecano.solve.events.events import some_happened
from mecano.solve.linear import multifrontal
from mecano.solve.time import increments
from mecano.solve.time.constrained_mass import assemble_mass
from mecano.solve.time.error_bound import bound_error
from mecano.solve.time.interpolate import between_states
from mecano.solve.time.output import record_step
from mecano.solve.time.repeated_steps import LARGER
from mecano.solve.time.step import attempt
from mecano.solve.time.step_change import change_step
from mecano.solve.time.stride import stride
from mecano.solve.time.unresolved_oscillation import count_changes

# The longest first, so that no core waits for them at the end.
GENERALIZED_ALPHA = attempt, change_step, stride, increments.motion_tangents
TIME_INTEGRATION = (
    multifrontal.solve, record_step, multifrontal.substitute, assemble_mass,
    assembly_driver.add, assembly_driver.assemble, assembly_driver.assemble_residual,
    assembly_driver.constraint_derivatives, assembly_driver.observe, assembly_driver.commit, sampler.fill,
    increments.move, count_changes, extremes.update,
)  # fmt: skip

EVENTS = assembly_driver.event_values, some_happened, between_states


def radau() -> tuple[Entry, ...]:
    """Return the functions that Radau IIA needs in addition to those of the time integration."""
    from mecano.solve.linear.factors import factor, solve  # no ordinary run needs them
    from mecano.solve.time.radau_output import interpolate_stages, sample_stages
    from mecano.solve.time.radau_step import attempt
    from mecano.solve.time.radau_stride import stride

    return attempt, stride, interpolate_stages, sample_stages, factor, solve


def divided() -> list[Code]:
    """Return the Codes that two threads need for a large model."""
    from mecano.jit.thread_pool import help_out  # no small model needs them
    from mecano.model import divided_loops
    from mecano.solve.linear import divided_multifrontal as linear

    entries = linear.factor_half, linear.solve, linear.substitute, linear.forward_half, linear.backward_half, help_out
    return [*(entry.code for entry in entries), *map(divided_loops.code_of, divided_loops.FUNCTIONS)]


def compile_time_integration(system: System, time: Values) -> None:
    """Load the time integration and the loops of ``system``; compile on all cores those missing from the store.

    ``time`` are the checked values of that section of the deck. Everything else is compiled when it is needed.
    """
    if time["method"] == "radau":
        own = radau()
    else:
        own = (*GENERALIZED_ALPHA, bound_error) if time["adaptive"] else GENERALIZED_ALPHA
    if time["adaptive"] and time["method"] != "radau" and system.massless.any():
        from mecano.solve.time.relaxed_error import relax_error  # not needed by models without massless unknowns

        own += (relax_error,)
    if system.is_sampled() and time["method"] != "radau":
        from mecano.solve.time.restart import restart  # nor by those without samples, or without signals
        from mecano.solve.time.sampled_restart import restart_at_sample

        own += restart, restart_at_sample
    elif system.signals.any():
        from mecano.solve.time.compiled_signals import settle_at_once

        own += (settle_at_once,)
    own += EVENTS if system.n_events else ()
    own += (multifrontal.residual,) if system.n_events and system.n >= LARGER else ()
    further = [] if system.halves is None else divided()
    codes = [*(entry.code for entry in (*own, *TIME_INTEGRATION)), *system.codes(), *further]
    compile_ahead(codes)
    machine_code.load(codes)
