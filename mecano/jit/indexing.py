"""Code of ``A[i]``, ``A[i, j]``, ... and of assignments to them: a tenth of the instructions that numba generates."""

import operator

from llvmlite import ir
from numba.core import cgutils, types
from numba.core.imputils import lower_builtin
from numba.np.arrayobj import getitem_array_tuple, getitem_arraynd_intp, load_item, setitem_array, store_item

from mecano.jit.aggregates import DATA, SHAPE, STRIDES, array_at


def _number_of_integers(index):
    """Return how many integers an index of this type consists of, 0 if there is anything else in it."""
    integers = index.types if isinstance(index, types.BaseTuple) else [index]
    return len(integers) if all(isinstance(integer, types.Integer) for integer in integers) else 0


def _address(context, builder, array, value, index, given):
    """Return the address of the item of an array (numba type and value) at an index (type and value).

    An index with fewer integers than a contiguous array has dimensions gives the first of many items.
    """
    is_tuple = isinstance(index, types.BaseTuple)
    integers, given = (index.types, cgutils.unpack_tuple(builder, given)) if is_tuple else ([index], [given])
    data, shape, strides = (builder.extract_value(value, place) for place in (DATA, SHAPE, STRIDES))
    places = [
        _from_start(context, builder, integer, i, shape, axis)
        for axis, (integer, i) in enumerate(zip(integers, given, strict=True))
    ]
    if array.layout == "C":
        place = places[0]
        for axis in range(1, array.ndim):
            place = builder.mul(place, builder.extract_value(shape, axis))
            place = builder.add(place, places[axis]) if axis < len(places) else place
        return builder.gep(data, [place])
    steps = [builder.mul(i, builder.extract_value(strides, axis)) for axis, i in enumerate(places)]
    offset = steps[0]
    for step in steps[1:]:
        offset = builder.add(offset, step)
    return builder.inttoptr(builder.add(builder.ptrtoint(data, offset.type), offset), data.type)


def _from_start(context, builder, integer, i, shape, axis):
    """Return the index along an axis that counts from the start, as negative constants count from the end.

    Other indices are not tested for being negative: that would be a third of the instructions of loops over elements.
    """
    i = context.cast(builder, i, integer, types.intp)
    is_negative = isinstance(i, ir.Constant) and i.constant < 0
    return builder.add(i, builder.extract_value(shape, axis)) if is_negative else i


@lower_builtin(operator.getitem, types.Array, types.Integer)
@lower_builtin(operator.getitem, types.Array, types.BaseTuple)
def _get(context, builder, signature, arguments):
    (array, index), (value, given) = signature.args, arguments
    n = _number_of_integers(index)
    if n == array.ndim:
        return load_item(context, builder, array, _address(context, builder, array, value, index, given))
    if n and array.layout == "C":
        shape = cgutils.unpack_tuple(builder, builder.extract_value(value, SHAPE))[n:]
        first = _address(context, builder, array, value, index, given)
        return array_at(context, builder, signature.return_type, first, shape)
    generic = getitem_array_tuple if isinstance(index, types.BaseTuple) else getitem_arraynd_intp
    return generic(context, builder, signature, arguments)


@lower_builtin(operator.setitem, types.Array, types.Any, types.Any)
def _set(context, builder, signature, arguments):
    (array, index, item_type), (value, given, new) = signature.args, arguments
    if _number_of_integers(index) != array.ndim or isinstance(item_type, types.Array):
        return setitem_array(context, builder, signature, arguments)
    item = _address(context, builder, array, value, index, given)
    return store_item(context, builder, array, context.cast(builder, new, item_type, array.dtype), item)
