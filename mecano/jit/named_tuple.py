"""Arguments of compiled functions that belong together: named tuples (typing.NamedTuple) with annotated fields.

Compiled code receives the tuple itself. A call from Python passes its numbers and arrays one after the other, taken
from any object that has attributes of these names: a State for a Motion, say.
"""


def is_named_tuple(hint):
    """Return whether an annotation is a class of named tuples."""
    return isinstance(hint, type) and issubclass(hint, tuple)


def leaves(annotations):
    """Return {path: type} of the numbers and arrays of which arguments with these ``annotations`` consist."""
    found = {}
    for name, hint in annotations.items():
        own = leaves(hint.__annotations__) if is_named_tuple(hint) else None
        found |= {name: hint} if own is None else {f"{name}.{path}": leaf for path, leaf in own.items()}
    return found


def spread(hints, values):
    """Return the numbers and arrays of arguments with these type ``hints``, one after the other."""
    found = []
    for hint, value in zip(hints, values, strict=True):
        if is_named_tuple(hint):
            found += spread(hint.__annotations__.values(), [getattr(value, name) for name in hint.__annotations__])
        else:
            found.append(value)
    return found


def gathered(hints, leaf):
    """Return the source of arguments with these type ``hints``, made of those that the iterator ``leaf`` gives."""
    return ", ".join(
        f"{hint.__name__}({gathered(hint.__annotations__.values(), leaf)})" if is_named_tuple(hint) else next(leaf)
        for hint in hints
    )


def classes(hints):
    """Return {name: class} of the named tuples among the type ``hints`` and their fields."""
    found = {}
    for hint in filter(is_named_tuple, hints):
        found |= {hint.__name__: hint} | classes(hint.__annotations__.values())
    return found
