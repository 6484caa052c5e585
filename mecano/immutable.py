"""Dataclasses that are compared by identity, ``immutable`` or ``mutable``.

``dataclasses`` generates and compiles methods for each class when its module is imported, which took a twelfth of the
processor time of a short run. The methods below serve all of these classes.
"""

from dataclasses import MISSING, FrozenInstanceError, dataclass, field, fields
from functools import cache
from typing import Any, dataclass_transform


@dataclass_transform(eq_default=False, frozen_default=True, field_specifiers=(field,))
def immutable(cls: type | None = None, *, kw_only: bool = False) -> Any:
    """Make a class a frozen dataclass, with ``kw_only`` as there; used as a decorator."""

    def decorate(cls):
        cls.__setattr__ = cls.__delattr__ = _refuse
        return mutable(cls, kw_only)

    return decorate if cls is None else decorate(cls)


@dataclass_transform(eq_default=False, field_specifiers=(field,))
def mutable(cls: Any, kw_only: bool = False) -> Any:
    """Make a class a dataclass; used as a decorator."""
    cls.__init__, cls.__repr__ = _set_fields, _text
    return dataclass(init=False, eq=False, repr=False, kw_only=kw_only)(cls)


@cache
def _declared(cls: Any):
    """Return the names of the fields of a class and of those given by position, its defaults, and those to be made."""
    declared = fields(cls)
    defaults = {f.name: f.default for f in declared if f.default is not MISSING}
    made = [(f.name, f.default_factory) for f in declared if f.default_factory is not MISSING]
    given = {f.name for f in declared if f.init}
    return given, [f.name for f in declared if f.init and not f.kw_only], defaults, made


def _set_fields(self, *values, **named):
    cls: Any = type(self)
    names, order, defaults, made = _declared(cls)
    given = dict(zip(order, values, strict=False), **named)
    if len(given) < len(values) + len(named) or not given.keys() <= names:
        raise TypeError(f"{cls.__name__} has the fields {order}, was given {values} and {[*named]}")
    self.__dict__.update(defaults)
    self.__dict__.update(given)
    for name, make in made:
        if name not in given:
            self.__dict__[name] = make()
    if not names <= self.__dict__.keys():
        raise TypeError(f"{cls.__name__} needs {sorted(names - self.__dict__.keys())}")
    if hasattr(self, "__post_init__"):
        self.__post_init__()


def _refuse(self, name, *value):
    raise FrozenInstanceError(f"cannot change {name!r} of a {type(self).__name__}")


def _text(self):
    values = (f"{f.name}={getattr(self, f.name)!r}" for f in fields(self) if f.repr)
    return f"{type(self).__qualname__}({', '.join(values)})"
