"""Arguments of compiled functions that belong together: named tuples (typing.NamedTuple) with annotated fields.

Compiled code receives the tuple itself. A call from Python passes its numbers and arrays one after the other, taken
from any object that has attributes of these names: a State for a Motion, say.
"""


def is_named_tuple(kind):
    """Return whether an annotation is a class of named tuples."""
    return isinstance(kind, type) and issubclass(kind, tuple)


def leaves(annotations):
    """Return {path: type} of the numbers and arrays of which arguments with these ``annotations`` consist."""
    found = {}
    for name, kind in annotations.items():
        own = leaves(kind.__annotations__) if is_named_tuple(kind) else None
        found |= {name: kind} if own is None else {f"{name}.{path}": leaf for path, leaf in own.items()}
    return found


def spread(kinds, values):
    """Return the numbers and arrays of arguments of these ``kinds``, one after the other."""
    found = []
    for kind, value in zip(kinds, values, strict=True):
        if is_named_tuple(kind):
            found += spread(kind.__annotations__.values(), [getattr(value, name) for name in kind.__annotations__])
        else:
            found.append(value)
    return found


def gathered(kinds, leaf):
    """Return the source of arguments of these ``kinds``, made of those that the iterator ``leaf`` gives."""
    return ", ".join(
        f"{kind.__name__}({gathered(kind.__annotations__.values(), leaf)})" if is_named_tuple(kind) else next(leaf)
        for kind in kinds
    )


def classes(kinds):
    """Return {name: class} of the named tuples among the ``kinds`` and their fields."""
    found = {}
    for kind in filter(is_named_tuple, kinds):
        found |= {kind.__name__: kind} | classes(kind.__annotations__.values())
    return found
