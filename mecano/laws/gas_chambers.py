r"""Gas of a strut, in one chamber or in two behind one another.

The gas of chamber i is compressed by a polytropic process, :math:`p V^{n_i} = p_i V_i^{n_i}`. Below its pressure
:math:`p_2` the second chamber is closed by its separator. Above it both have the same pressure p, which follows from
the volume that is left to them at the extension e of a piston of area A,

.. math::  V_1 (p_1/p)^{1/n_1} + V_2 (p_2/p)^{1/n_2} = V_1 + V_2 + A e, \qquad
           F = -p A, \qquad dF/de = p A^2 / (v_1/n_1 + v_2/n_2)

with the volumes :math:`v_1, v_2` of the left side. Newton's iteration of the logarithm of this equation in ln p is
exact after one step if the exponents are equal, and approaches the solution from one side otherwise.
"""

import math

import numpy as np

from mecano.jit.kernel import kernel
from mecano.laws.gas_spring import LEAST, gas_force, gas_work
from mecano.maths.dual import chain, value

CLOSED = 1e300  # [m] stroke that opens a second chamber where there is none
ITERATIONS = 30  # of Newton; four suffice for exponents from 1 to 1.4
GAS_RECORD = {"pressure": 2, "volume": 2, "exponent": 2, "gas_area": (), "opens": ()}


@kernel
def gas_at(p, e):
    """Return force [N] > 0 in tension, its derivative, and energy [J] of the gas, without the air around, at e [m]."""
    if e > -p.opens:
        push, column = p.pressure[0] * p.gas_area, p.volume[0] / p.gas_area
        F, slope = gas_force(push, column, p.exponent[0], e)
        return F, slope, gas_work(push, column, p.exponent[0], e)
    volume, least = p.volume[0] + p.volume[1] + p.gas_area * e, LEAST * (p.volume[0] + p.volume[1])
    pressure, compressibility = common_pressure(p, max(volume, least))
    F, slope = -pressure * p.gas_area, p.gas_area * p.gas_area / compressibility
    beyond = min(volume - least, 0.0) / p.gas_area  # along the tangent, as of a gas spring
    work = compression_work(p, 0, pressure) + compression_work(p, 1, pressure)
    return F + slope * beyond, slope, work + beyond * (F + 0.5 * slope * beyond)


@kernel
def common_pressure(p, volume):
    """Return the pressure [Pa] of both chambers, and -dV/dp [m3/Pa], when they share the ``volume`` [m3]."""
    x = math.log(p.pressure[1])
    for _ in range(ITERATIONS):
        first = p.volume[0] * math.exp((math.log(p.pressure[0]) - x) / p.exponent[0])
        second = p.volume[1] * math.exp((math.log(p.pressure[1]) - x) / p.exponent[1])
        rate = first / p.exponent[0] + second / p.exponent[1]
        step = math.log((first + second) / volume) * (first + second) / rate
        x += step
        if abs(step) < 1e-14 * abs(x):
            break
    return math.exp(x), rate / math.exp(x)


@kernel
def compression_work(p, i, pressure):
    """Return the work [J] that compresses the gas of chamber i to the ``pressure`` [Pa]."""
    x = math.log(pressure / p.pressure[i]) / p.exponent[i]
    y = (p.exponent[i] - 1.0) * x
    return p.pressure[i] * p.volume[i] * x * (math.expm1(y) / y if y != 0.0 else 1.0)


@kernel
def gas_pull(p, e):
    """Return the force of the gas [N], without the air around; a Dual if e is one."""
    F, slope, _ = gas_at(p, value(e))
    return chain(e, F, slope)


def gas_values(gas, second):
    """Return the values of ``GAS_RECORD`` for the checked mappings of one gas chamber and of a second one, or None."""
    stages, opens = (gas, second or gas), CLOSED
    exponents = [gas["exponent"] if stage.get("exponent") is None else stage["exponent"] for stage in stages]
    if second is not None:
        opens = gas["volume"] / gas["area"] * (1.0 - (gas["pressure"] / second["pressure"]) ** (1.0 / exponents[0]))
    return {
        "pressure": np.array([stage["pressure"] for stage in stages]),
        "volume": np.array([stage["volume"] for stage in stages]),
        "exponent": np.array(exponents), "gas_area": gas["area"], "opens": opens,
    }  # fmt: skip
