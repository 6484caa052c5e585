"""The registry: one line for each kind of element, joint and load, nothing else."""

from mecano.elements.couple import COUPLE
from mecano.elements.force import FOLLOWER_FORCE, FORCE
from mecano.elements.moment import FOLLOWER_MOMENT, MOMENT
from mecano.elements.spring_damper import SPRING_DAMPER
from mecano.elements.torsion_spring_damper import TORSION_SPRING_DAMPER

KINDS = {
    kind.name: kind
    for kind in (
        SPRING_DAMPER, TORSION_SPRING_DAMPER,
        FORCE, FOLLOWER_FORCE, MOMENT, FOLLOWER_MOMENT, COUPLE,
    )
}  # fmt: skip
