"""Laws: scalar functions with exact derivatives, shared by all elements that need one.

A checked law is a tuple of (term name, {field: value}), whose terms are summed. The terms are registered here, one
line each; see mecano.laws.law_table for their evaluation.
"""

from mecano.laws.acceleration import ACCELERATION
from mecano.laws.dampers import DAMPER_POLYNOMIAL, DAMPER_TABLE, DRY_FRICTION, METERING_PIN, OIL_DAMPER
from mecano.laws.gas_spring import GAS_SPRING
from mecano.laws.linear_forces import DAMPER, PRELOAD, SPRING
from mecano.laws.polynomial import CONSTANT, LINEAR, POLYNOMIAL
from mecano.laws.power import DAMPER_POWER, POWER
from mecano.laws.roads import BUMP, RANDOM
from mecano.laws.stops import DEAD_BAND, STOP
from mecano.laws.tabulated import TABLE
from mecano.laws.time_functions import EXPONENTIAL, RAMP, SINE, STEP

TERMS = {
    term.name: term
    for term in (
        CONSTANT, LINEAR, POLYNOMIAL, POWER, TABLE, SINE, RAMP, STEP, EXPONENTIAL, ACCELERATION, BUMP, RANDOM,
        SPRING, PRELOAD, DAMPER, DAMPER_POLYNOMIAL, DAMPER_POWER, DAMPER_TABLE, GAS_SPRING, OIL_DAMPER, METERING_PIN,
        DRY_FRICTION, STOP, DEAD_BAND,
    )
}  # fmt: skip
