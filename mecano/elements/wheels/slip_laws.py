"""The registry of slip laws, one line for each, and the choice among them."""

from mecano.elements.wheels.fiala import FIALA
from mecano.elements.wheels.magic_formula import MAGIC_FORMULA
from mecano.elements.wheels.sliding_friction import SLIDING_FRICTION
from mecano.elements.wheels.yawed_rolling import YAWED_ROLLING

SLIP_LAWS = {law.name: law for law in (SLIDING_FRICTION, FIALA, MAGIC_FORMULA, YAWED_ROLLING)}


def given_law(values):
    """Return the SlipLaw that the values of a tyre law contain, or None."""
    return next((law for law in SLIP_LAWS.values() if values.get(law.name) is not None), None)
