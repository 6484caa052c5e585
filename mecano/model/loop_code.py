"""The compiled loops, and the functions of a kind that they call: templates of element_calls.py with the function of
the kind among their globals.
"""

import types
from collections.abc import Callable, Iterable
from functools import cache
from typing import NamedTuple

from mecano.element_interface import UNUSED, Kind, record
from mecano.jit.digest import digest
from mecano.jit.machine_code import Code, address
from mecano.model import element_calls, lane_loops, loops

NO_PARAMETERS = record(**{UNUSED: ()})
# For each purpose: the loop, the template of the call, the function of the kind.
PURPOSES = {
    loops.tangent: (loops.tangent, element_calls.tangent, "force"),
    loops.residual: (loops.residual, element_calls.force, "force"),
    loops.constraint_derivatives: (loops.constraint_derivatives, element_calls.constraints, "constraints"),
    loops.observe: (loops.observe, element_calls.observe, "observe"),
    loops.event_values: (loops.event_values, element_calls.event_values, "event_values"),
    loops.commit: (loops.commit, element_calls.commit, "commit"),
}  # fmt: skip
BY_LANES = {
    loops.tangent: (lane_loops.tangent, element_calls.lanes_tangent, "force"),
    loops.residual: (lane_loops.residual, element_calls.lanes_force, "force"),
    loops.observe: (lane_loops.observe, element_calls.lanes_observe, "observe"),
}  # fmt: skip
BY_DUALS = loops.dual_tangent, element_calls.dual_residual, "residual"
BY_RESIDUAL = loops.residual, element_calls.residual, "residual"


class Codes(NamedTuple):
    """The code of a loop, and of the functions of a kind that it calls."""

    loop: Code
    function: Code
    inertia: Code | None


class Calls(NamedTuple):
    """The addresses of a loop, and of the functions of a kind that it calls; 0 without inertia."""

    loop: int
    function: int
    inertia: int


def calls_of(kind: Kind, purpose: Callable[..., None]) -> Calls | None:
    """Return the addresses of the loop of a purpose and of its callees, or None if the kind has no such function."""
    found = codes_of(kind, purpose)
    return None if found is None else Calls(*(0 if code is None else _address(code) for code in found))


def codes_of(kind: Kind, purpose: Callable[..., None]) -> Codes | None:
    """Return the code of the loop of a purpose and of its callees, or None if the kind has no such function."""
    loop, template, name = _of(kind, purpose)
    function, parameters = getattr(kind, name), kind.dtype
    if function is None and purpose is loops.event_values and kind.events:
        function, parameters = element_calls.no_event_values, NO_PARAMETERS
    if function is None:
        return None
    inertia = kind.inertia if loop is loops.dual_tangent else None
    return Codes(
        loop_code(loop), _code(template, function, parameters),
        None if inertia is None else _code(element_calls.inertia, inertia, parameters),
    )  # fmt: skip


def all_codes(kinds: Iterable[Kind]) -> list[Code]:
    """Return the Codes of the loops of all purposes for some kinds, and of their callees."""
    found = [codes_of(kind, purpose) for kind in kinds for purpose in PURPOSES]
    return [code for codes in found if codes is not None for code in codes if code is not None]


def _of(kind, purpose):
    """Return the loop of a purpose for a kind, the template of the call, and the name of the function of the kind."""
    if kind.by_lanes and purpose in BY_LANES:
        return BY_LANES[purpose]
    if kind.residual is not None and purpose is loops.tangent:
        return BY_DUALS
    if kind.residual is not None and purpose is loops.residual:
        return BY_DUALS if kind.senses else BY_RESIDUAL  # a sensor takes longer, but is compiled once
    return PURPOSES[purpose]


@cache
def loop_code(loop: Callable[..., None]) -> Code:
    """Return the Code of a loop."""
    name = f"{loop.__module__.rpartition('.')[2]}_{loop.__name__}"
    return Code(name, digest(loop), lambda compiler: compiler.loop_code(loop))


@cache
def _code(template, function, parameters):
    """Return the Code of a call; kinds with the same function and record of parameters share one."""
    values = {**template.__globals__, "function": function, "parameters": parameters}
    name = f"{template.__name__}_{function.__module__.rpartition('.')[2]}"
    bound = types.FunctionType(template.__code__, values, name)
    return Code(name, digest(bound), lambda compiler: compiler.loop_code(bound))


_address = cache(address)
