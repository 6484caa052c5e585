"""Names of the values that wheels record besides those of their slip law: no value of a slip law can have them."""

from mecano.elements.wheels.enveloping import enveloping_law
from mecano.elements.wheels.fiala import FIALA
from mecano.elements.wheels.rolling_tyre import rolling_law
from mecano.elements.wheels.sliding_friction import SLIDING_FRICTION
from mecano.elements.wheels.transient_wheel import TRANSIENT_WHEEL
from mecano.elements.wheels.turn_slip import twisting_law
from mecano.elements.wheels.wheel import WHEEL
from mecano.elements.wheels.wheel_on_body import WHEEL_ON_BODY

WITH_CAMS = enveloping_law(SLIDING_FRICTION, True)


def names_of_wheels() -> set[str]:
    """Return the names in the records of all wheels with a slip law that do not belong to the law."""
    records = [(kind.dtype.names, SLIDING_FRICTION) for kind in (WHEEL, WHEEL_ON_BODY)]
    records += [(law.record, SLIDING_FRICTION) for law in (rolling_law(SLIDING_FRICTION), WITH_CAMS)]
    records += [(TRANSIENT_WHEEL.dtype.names, FIALA), (twisting_law(FIALA, FIALA.name).record, FIALA)]
    return {name for names, law in records for name in names if name not in law.record}
