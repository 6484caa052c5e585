"""Kinds for the tests that every one of them must pass."""

from mecano.constraints import CONSTRAINTS
from mecano.elements import KINDS

ALL_KINDS = {**KINDS, **CONSTRAINTS}
