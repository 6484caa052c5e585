"""Classes of values that do not change: frozen dataclasses that are compared by identity.

``dataclasses`` generates and compiles the text and the comparison of each class when its module is imported, which took
a twentieth of the processor time of a short run. One text serves all of these classes.
"""

from dataclasses import dataclass, field, fields
from typing import Any, dataclass_transform


@dataclass_transform(eq_default=False, frozen_default=True, field_specifiers=(field,))
def immutable(cls: type | None = None, *, kw_only: bool = False, init: bool = True) -> Any:
    """Make a class a frozen dataclass, with ``kw_only`` and ``init`` as there; used as a decorator."""

    def decorate(cls):
        cls.__repr__ = _text
        return dataclass(frozen=True, eq=False, repr=False, kw_only=kw_only, init=init)(cls)

    return decorate if cls is None else decorate(cls)


def _text(self):
    values = (f"{f.name}={getattr(self, f.name)!r}" for f in fields(self) if f.repr)
    return f"{type(self).__qualname__}({', '.join(values)})"
