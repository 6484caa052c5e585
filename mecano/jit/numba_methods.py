"""Implementation of methods.py for numba: types and instructions of operators, functions with methods, attributes.

A method runs on Symbols (symbols.py) where its caller is compiled.
"""

import operator
from functools import cache

from numba.core import cgutils, types
from numba.core.imputils import lower_builtin, lower_getattr
from numba.core.typing.templates import AbstractTemplate, AttributeTemplate, infer_getattr, infer_global, signature
from numba.extending import overload

from mecano.jit import methods, symbols
from mecano.jit.lanes import ALIGNMENT, Lanes, Mask
from mecano.jit.symbols import NUMBER, NUMBERS, Condition, Symbol, any_many, is_number, value_of

NUMERIC = (types.Number, types.Boolean, type(Lanes), type(Mask))


def _dispatched_type(argument):
    """Return the type by which a method is dispatched, for an argument of this numba type."""
    if isinstance(argument, types.BaseNamedTuple):
        return argument.instance_class
    if isinstance(argument, types.Record):
        return methods.type_of_record(argument.fields)
    return tuple if isinstance(argument, types.BaseTuple) else float if isinstance(argument, NUMERIC) else None


@overload(operator.setitem)
def _store(array, index, value):
    """Store a Dual, or a number as a constant Dual, in an array of records."""
    if not (isinstance(array, types.Array) and isinstance(array.dtype, types.Record)):
        return None
    if isinstance(value, types.Number):
        return _store_number
    item, of = _dispatched_type(array.dtype), _dispatched_type(value)
    return _store_dual if of is not None and of is item else None


def _store_number(array, index, value):
    item = array[index]
    item.value = value
    item.slope = 0.0


def _store_dual(array, index, value):
    item = array[index]
    item.value = value.value
    item.slope = value.slope


IN_PLACE = {operator.add: operator.iadd, operator.sub: operator.isub, operator.mul: operator.imul}
COMPOSED = (types.BaseNamedTuple, types.Record, type(Lanes))  # types of operands that numba does not know
OPERANDS = (*COMPOSED, types.Float, types.Integer)
_known = set()  # functions with methods that have been registered with numba
methods.Generic.primitive = staticmethod(symbols.primitive)


def register_methods():
    """Register operators, functions with methods, and attributes, that numba does not know yet."""
    operators = *methods.UNARY, *methods.BINARY  # those of Lanes need no methods
    for function in [f for f in dict.fromkeys((*operators, *methods.functions())) if f not in _known]:
        for named in {function, IN_PLACE.get(function, function)}:
            _register(function, named)
        _known.add(function)
    for name in [name for name in methods.attribute_names() if name not in _known]:
        _register_attribute(name)
        _known.add(name)


def _register(function, named):
    """Register a function, called under the name ``named``, with numba: its types and its code generation."""

    class Template(AbstractTemplate):
        key = named

        def generic(self, arguments, _):
            result = _result(function, arguments)
            return result and signature(result, *arguments)

    infer_global(named, types.Function(Template))

    def generate(context, builder, of, arguments):
        given = [_symbolic(context, builder, *pair) for pair in zip(of.args, arguments, strict=True)]
        return _instructions(context, builder, of.return_type, function(*given))

    if isinstance(function, methods.Generic):
        lower_builtin(named, types.VarArg(types.Any))(generate)
        return
    unary = [(of,) for of in COMPOSED]
    for operands in [*unary, *((a, b) for a in OPERANDS for b in OPERANDS if {a, b} & {*COMPOSED})]:
        lower_builtin(named, *operands)(generate)


def _register_attribute(name):
    class Attribute(AttributeTemplate):
        key = types.BaseNamedTuple

        def generic_resolve(self, of, attribute):
            code = methods.attribute_of(_dispatched_type(of), name) if attribute == name else None
            return code and _type_of(code(_placeholder(of)))

    infer_getattr(Attribute)

    def generate(context, builder, of, value):
        found = methods.attribute_of(_dispatched_type(of), name)(_symbolic(context, builder, of, value))
        return _instructions(context, builder, _type_of(found), found)

    lower_getattr(types.BaseNamedTuple, name)(generate)


@cache
def _result(function, arguments):
    """Return the result type of a function for arguments of these types, or None if it has no method for them."""
    dispatched_types = set(map(_dispatched_type, arguments))
    plain = dispatched_types == {float} and Lanes not in arguments
    if None in dispatched_types or (plain and not isinstance(function, methods.Generic)):
        return None
    try:
        return _type_of(function(*map(_placeholder, arguments)))
    except TypeError:
        return None


def _placeholder(of):
    """Return a placeholder value of a numba type, without instructions; raise TypeError if it has no methods."""
    cls = _dispatched_type(of)
    if cls is None:
        raise TypeError(f"{of} is no operand")
    if cls is float:
        placeholder = Condition if isinstance(of, types.Boolean) or of is Mask else Symbol
        return placeholder(None, many=of in (Lanes, Mask))
    parts = [of.typeof(name) for name in of.fields] if isinstance(of, types.Record) else of.types
    return cls(*map(_placeholder, parts))


def _type_of(value):
    if isinstance(value, Condition | bool):
        return Mask if any_many([value]) else types.boolean
    if is_number(value):
        return Lanes if any_many([value]) else types.float64
    parts = [_type_of(part) for part in value]
    if len(set(parts)) == 1:
        return types.NamedUniTuple(parts[0], len(parts), type(value))
    return types.NamedTuple(parts, type(value))


def _symbolic(context, builder, of, value):
    """Return a value of compiled code as Symbols."""
    cls = _dispatched_type(of)
    if of is Lanes:
        return Symbol(builder, value)
    if isinstance(of, types.Boolean) or of is Mask:
        return Condition(builder, value if of is Mask else context.cast(builder, value, of, types.boolean))
    if cls is float:
        return Symbol(builder, context.cast(builder, value, of, types.float64))
    if isinstance(of, types.Record):
        return cls(*(Symbol(builder, _loaded(builder, of, value, name)) for name in of.fields))
    parts = cgutils.unpack_tuple(builder, value, len(of))
    return cls(*(_symbolic(context, builder, *pair) for pair in zip(of.types, parts, strict=True)))


def _loaded(builder, of, record, name):
    """Return the number, or the numbers of LANES elements, of a field of a record."""
    number = NUMBERS if of.typeof(name) is Lanes else NUMBER
    return builder.load(cgutils.get_record_member(builder, record, of.offset(name), number), align=ALIGNMENT)


def _instructions(context, builder, of, value):
    """Return numba's value for a value made of Symbols."""
    if isinstance(value, Condition | bool):
        return value.value if isinstance(value, Condition) else context.get_constant(types.boolean, value)
    if is_number(value):
        return value_of(value)
    parts = [_instructions(context, builder, *pair) for pair in zip(of.types, value, strict=True)]
    return context.make_tuple(builder, of, parts)
