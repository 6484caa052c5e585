"""Code of ``A[i]``, ``A[i, j]`` and of assignments to them: a tenth of the instructions that numba generates."""

import operator

from llvmlite import ir
from numba.core import types
from numba.core.imputils import lower_builtin
from numba.np.arrayobj import getitem_array_tuple, getitem_arraynd_intp, load_item, setitem_array, store_item


def _names_item(array, index):
    """Return True if an index of this type denotes one item of an array."""
    kinds = index.types if isinstance(index, types.BaseTuple) else [index]
    return len(kinds) == array.ndim and all(isinstance(kind, types.Integer) for kind in kinds)


def _parts(builder, value, n):
    """Return the n values in a tuple, where possible those that it was made of."""
    found = [None] * n
    while isinstance(value, ir.instructions.InsertValue) and None in found:
        value, part, (i, *_) = *value.operands, value.indices
        found[i] = part if found[i] is None else found[i]
    return [builder.extract_value(value, i) if part is None else part for i, part in enumerate(found)]


def _item(context, builder, array, value, index, given):
    """Return the address of the item of an array (numba type and value) at an index (type and value)."""
    is_tuple = isinstance(index, types.BaseTuple)
    fields = context.data_model_manager[array]
    data, shape, strides = (builder.extract_value(value, fields.get_field_position(name)) for name in (
        "data", "shape", "strides"
    ))  # fmt: skip
    kinds, given = (index.types, _parts(builder, given, array.ndim)) if is_tuple else ([index], [given])
    places = [
        _from_start(context, builder, kind, i, shape, axis)
        for axis, (kind, i) in enumerate(zip(kinds, given, strict=True))
    ]
    if array.layout == "C":
        place = places[0]
        for axis, i in enumerate(places[1:], start=1):
            place = builder.add(builder.mul(place, builder.extract_value(shape, axis)), i)
        return builder.gep(data, [place])
    steps = [builder.mul(i, builder.extract_value(strides, axis)) for axis, i in enumerate(places)]
    offset = steps[0]
    for step in steps[1:]:
        offset = builder.add(offset, step)
    return builder.inttoptr(builder.add(builder.ptrtoint(data, offset.type), offset), data.type)


def _from_start(context, builder, kind, i, shape, axis):
    """Return the index along an axis that counts from the start, as negative ones count from the end."""
    i = context.cast(builder, i, kind, types.intp)
    if not kind.signed or (isinstance(i, ir.Constant) and i.constant >= 0):
        return i
    is_negative = builder.icmp_signed("<", i, ir.Constant(i.type, 0))
    return builder.select(is_negative, builder.add(i, builder.extract_value(shape, axis)), i)


@lower_builtin(operator.getitem, types.Array, types.Integer)
@lower_builtin(operator.getitem, types.Array, types.BaseTuple)
def _get(context, builder, signature, arguments):
    (array, index), (value, given) = signature.args, arguments
    if _names_item(array, index):
        return load_item(context, builder, array, _item(context, builder, array, value, index, given))
    generic = getitem_array_tuple if isinstance(index, types.BaseTuple) else getitem_arraynd_intp
    return generic(context, builder, signature, arguments)


@lower_builtin(operator.setitem, types.Array, types.Any, types.Any)
def _set(context, builder, signature, arguments):
    (array, index, kind), (value, given, new) = signature.args, arguments
    if not _names_item(array, index) or isinstance(kind, types.Array):
        return setitem_array(context, builder, signature, arguments)
    item = _item(context, builder, array, value, index, given)
    return store_item(context, builder, array, context.cast(builder, new, kind, array.dtype), item)
