"""The code of the loops of a kind: templates of loops.py, with the function of the kind among their globals."""

import types
from functools import cache

from mecano.element_interface import UNUSED, record
from mecano.jit.digest import digest
from mecano.jit.store import Code, address
from mecano.model.loops import (
    commit,
    constraint_derivatives,
    dual_constraint_derivatives,
    dual_tangent,
    event_values,
    no_event_values,
    no_inertia,
    observe,
    plain_residual,
    residual,
    tangent,
)  # fmt: skip

NO_PARAMETERS = record(**{UNUSED: ()})
# The function of a kind that each loop calls.
PURPOSES = {
    tangent: "force", residual: "force", dual_tangent: "residual", plain_residual: "residual",
    constraint_derivatives: "constraint_derivatives", dual_constraint_derivatives: "constraints",
    observe: "observe", event_values: "event_values", commit: "commit",
}  # fmt: skip


def loop_of(kind, template):
    """Return the address of the compiled loop ``template`` for a kind, or None if the kind has no such function."""
    code = code_of(kind, template)
    return None if code is None else _address(code)


def code_of(kind, template):
    """Return the Code of the loop ``template`` for a kind, or None if the kind has no such function."""
    if kind.residual is not None:
        alone = dual_tangent if kind.senses else plain_residual  # a sensor takes longer, but is compiled once
        template = {tangent: dual_tangent, residual: alone}.get(template, template)
    if kind.constraints is not None and template is constraint_derivatives:
        template = dual_constraint_derivatives
    function = getattr(kind, PURPOSES[template])
    if template is event_values and function is None and kind.events:
        return _code(template, no_event_values, None, NO_PARAMETERS, False)
    inertia = kind.inertia if template is dual_tangent else None
    return None if function is None else _code(template, function, inertia, kind.dtype, kind.of_rates)


@cache
def _code(template, function, inertia, parameters, of_rates):
    """Return the Code of the loop; kinds with the same function and record of parameters share one."""
    values = {
        **template.__globals__, "function": function, "inertia": inertia or no_inertia,
        "has_inertia": inertia is not None, "parameters": parameters, "of_rates": of_rates,
    }  # fmt: skip
    name = f"{template.__name__}_{function.__module__.rpartition('.')[2]}"
    bound = types.FunctionType(template.__code__, values, name)
    return Code(name, digest(bound), lambda compiler: compiler.loop_code(bound))


_address = cache(address)
