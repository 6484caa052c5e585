"""Numbers of four elements, or slopes along four directions, for numba: processors compute with all four at once.

``Lanes`` is the type of such numbers, ``Mask`` that of a comparison of them. Both mix with numbers that are the same
for all four elements. symbols.py has their arithmetic.
"""

import numpy as np
from numba.core import types
from numba.core.datamodel.models import PrimitiveModel, RecordModel
from numba.core.imputils import lower_cast
from numba.core.typeconv import Conversion
from numba.extending import register_model
from numba.np.numpy_support import from_dtype

from mecano.jit.memory import LANES, lanes_dtype
from mecano.jit.symbols import CONDITIONS, NUMBERS, splat

ALIGNMENT = 8  # B, of stored Lanes
PLAIN = (types.Float, types.Integer, types.Boolean)


class _Lanes(types.Type):
    """The type of numbers of four elements."""

    bitwidth = 64 * LANES

    def can_convert_from(self, typing_context, other):
        """Return Conversion.safe for the number of one element, which then stands for all four."""
        return Conversion.safe if isinstance(other, PLAIN) else None

    def unify(self, typing_context, other):
        """Return the type of a variable that has one value or four."""
        return self if isinstance(other, PLAIN) else None


class _Mask(types.Type):
    """The type of comparisons of four elements."""


class _LanesRecord(types.Record):
    """The type of a record with Lanes: that of four elements, or a Dual."""

    @property
    def dtype(self):
        """A type of NumPy of the same size."""
        return np.dtype((np.void, self.size))


Lanes, Mask = _Lanes("Lanes"), _Mask("Mask")
DUAL = _LanesRecord(
    [("value", {"type": types.float64, "offset": 0}), ("slope", {"type": Lanes, "offset": 8})], 8 * (1 + LANES), False
)
"""The type of a stored Dual with a slope along each of LANES directions."""


@register_model(_Lanes)
class _LanesModel(PrimitiveModel):
    """An LLVM vector of numbers."""

    def __init__(self, manager, of):
        super().__init__(manager, of, NUMBERS)

    def load_from_data_pointer(self, builder, pointer, align=None):
        """Load four numbers, which begin at any number."""
        return builder.load(pointer, align=ALIGNMENT)


@register_model(_Mask)
class _MaskModel(PrimitiveModel):
    """An LLVM vector of truth values."""

    def __init__(self, manager, of):
        super().__init__(manager, of, CONDITIONS)


register_model(_LanesRecord)(RecordModel)


@lower_cast(types.Number, _Lanes)
@lower_cast(types.Boolean, _Lanes)
def _for_all(context, builder, of, to, value):
    return splat(builder, context.cast(builder, value, of, types.float64))


def lanes_record(dtype):
    """Return the numba type of the record of four elements; its layout is that of ``lanes_dtype``."""
    stored = lanes_dtype(dtype)
    fields = [(name, {"type": _field(dtype.fields[name][0]), "offset": stored.fields[name][1]}) for name in dtype.names]
    return _LanesRecord(fields, stored.itemsize, False)


def _field(of):
    """Return the type of a field: integers are the same for all four."""
    if of.base.kind == "i":
        return from_dtype(of)
    return types.NestedArray(Lanes, of.shape) if of.shape else Lanes
