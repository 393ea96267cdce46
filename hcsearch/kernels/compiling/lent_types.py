"""Types of kernels' arguments: a table is lent as one pointer to its fields, an array as its data and its shape.

numba passes a named tuple of arrays as seven or more values for each array, and compiles a kernel anew for each
combination of layouts and widths of integers. Here every kernel has one signature: the caller keeps its arrays and
named tuples, as numba has them, and lends them for the time of a call. A kernel that returns a table that it was lent
returns a named tuple.
"""

from __future__ import annotations

import hashlib
from typing import Any

from llvmlite import ir
from numba import extending
from numba.core import cgutils, imputils, types
from numba.core.datamodel import models
from numba.core.pythonapi import NativeValue
from numba.core.typing import templates
from numba.np.numpy_support import as_dtype

_WORD = 8
"""Bytes by which the fields of a table are aligned."""
_types: Any = types  # with attributes that numba does not declare
_templates: Any = templates
_word = ir.IntType(64)
_byte_pointer = ir.IntType(8).as_pointer()


class LentArray(_types.Array):
    """A C-ordered array that a kernel is lent: passed as owner, data and shape."""

    def __init__(self, dtype: Any, ndim: int) -> None:
        super().__init__(dtype, ndim, "C", name=f"lent({dtype}, {ndim}d)")


class LentTable(_types.Type):
    """A named tuple that a kernel is lent, passed as a pointer to its fields; tables in it are pointers, too."""

    def __init__(self, kind: Any, parts: tuple[Any, ...]) -> None:
        self.kind, self.parts = kind, parts
        super().__init__(f"{kind.__module__}.{kind.__qualname__}({', '.join(map(str, parts))})")

    @property
    def key(self) -> Any:
        """What makes types equal."""
        return self.kind, self.parts

    @property
    def mangling_args(self) -> Any:
        """The part of a symbol's name, which would otherwise spell all fields out."""
        return f"{self.kind.__name__}_{hashlib.blake2b(self.name.encode(), digest_size=8).hexdigest()}", ()


def lent_type(kind: Any) -> Any:
    """Return the type by which a kernel is lent a value: one for all layouts, widths and literals of one meaning."""
    kind = _types.unliteral(kind)
    if isinstance(kind, _types.BaseNamedTuple):
        named = kind.instance_class
        parts = zip(named._fields, kind.types, strict=True)
        return LentTable(named, tuple(_field_type(named, name, part) for name, part in parts))
    if isinstance(kind, _types.UniTuple | _types.Tuple):
        return _types.BaseTuple.from_types(tuple(lent_type(part) for part in kind.types))
    if isinstance(kind, _types.Array) and kind.layout == "C" and kind.aligned:
        return LentArray(kind.dtype, kind.ndim)
    return _types.int64 if isinstance(kind, _types.Integer) and kind.signed else kind


def _field_type(table: Any, name: str, kind: Any) -> Any:
    """Return the type of a field, which may be given as a whole number where the table has a real one."""
    is_real = isinstance(kind, _types.Integer) and table.__annotations__[name] in ("float", float)
    return _types.float64 if is_real else lent_type(kind)


def _array_type(kind: Any) -> Any:
    """Return the type of an array as numba has it."""
    return _types.Array(kind.dtype, kind.ndim, "C") if isinstance(kind, LentArray) else kind


def kept_type(kind: Any) -> Any:
    """Return the type by which a kernel returns a value: a table that it was lent is copied into a named tuple."""
    if isinstance(kind, LentArray):
        return _array_type(kind)
    if isinstance(kind, LentTable):
        return _types.BaseTuple.from_types(tuple(map(kept_type, kind.parts)), kind.kind)
    if isinstance(kind, _types.BaseTuple):
        return _types.BaseTuple.from_types(tuple(map(kept_type, kind.types)), getattr(kind, "instance_class", None))
    return kind


@extending.register_model(LentArray)
class _LentArrayModel(models.ArrayModel):
    def get_argument_type(self) -> Any:
        kinds = self.get_value_type().elements
        return kinds[0], kinds[4], *[_word] * self._fe_type.ndim

    def as_argument(self, builder: Any, value: Any) -> Any:
        shape = [builder.extract_value(value, [5, i]) for i in range(self._fe_type.ndim)]
        return builder.extract_value(value, 0), builder.extract_value(value, 4), *shape

    def from_argument(self, builder: Any, value: Any) -> Any:
        owner, data, *shape = value
        item_size = ir.Constant(_word, as_dtype(self._fe_type.dtype).itemsize)
        strides, size = [item_size], shape[-1]
        for length in shape[-2::-1]:
            strides.insert(0, builder.mul(size, item_size))
            size = builder.mul(size, length)
        array = cgutils.get_null_value(self.get_value_type())
        for place, part in ((0, owner), (2, size), (3, item_size), (4, data)):
            array = builder.insert_value(array, part, place)
        for place, parts in ((5, shape), (6, strides)):
            for i, part in enumerate(parts):
                array = builder.insert_value(array, part, [place, i])
        return array


@extending.register_model(LentTable)
class _LentTableModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, _byte_pointer)


@extending.lower_cast(LentArray, _types.Array)
@extending.lower_cast(_types.Array, LentArray)
def _same_array(context: Any, builder: Any, known: Any, wanted: Any, value: Any) -> Any:
    return value


@extending.lower_cast(_types.BaseNamedTuple, LentTable)
def _lend(context: Any, builder: Any, known: Any, wanted: Any, value: Any) -> Any:
    """Write the fields of a named tuple on the stack; only calls cast to this type, and the pointer ends with them."""
    offsets, table = _layout(context, wanted), _new_table(context, builder, wanted)
    for i, (offset, before, part) in enumerate(zip(offsets, known.types, wanted.parts, strict=False)):
        field = context.cast(builder, builder.extract_value(value, i), before, part)
        model = context.data_model_manager[part]
        builder.store(model.as_data(builder, field), _field_pointer(builder, table, offset, model.get_data_type()))
    return table


@extending.lower_cast(LentTable, _types.BaseNamedTuple)
def _keep(context: Any, builder: Any, known: Any, wanted: Any, value: Any) -> Any:
    fields = [_read(context, builder, known, value, place) for place in range(len(known.parts))]
    return _as_tuple(context, builder, fields, known.parts, wanted)


@extending.lower_cast(_types.BaseNamedTuple, _types.BaseNamedTuple)
def _keep_fields(context: Any, builder: Any, known: Any, wanted: Any, value: Any) -> Any:
    fields = [builder.extract_value(value, place) for place in range(len(known.types))]
    return _as_tuple(context, builder, fields, known.types, wanted)


def _as_tuple(context: Any, builder: Any, fields: Any, known: Any, wanted: Any) -> Any:
    parts = zip(fields, known, wanted.types, strict=True)
    return context.make_tuple(builder, wanted, [context.cast(builder, *part) for part in parts])


@_templates.infer_getattr
class _Fields(_templates.AttributeTemplate):
    key = LentTable

    def generic_resolve(self, table: Any, name: str) -> Any:
        names = table.kind._fields
        return _array_type(table.parts[names.index(name)]) if name in names else None


@extending.lower_getattr_generic(LentTable)
def _field(context: Any, builder: Any, table: Any, value: Any, name: str) -> Any:
    place = table.kind._fields.index(name)
    field = _read(context, builder, table, value, place)
    return imputils.impl_ret_borrowed(context, builder, table.parts[place], field)


@extending.unbox(LentTable)
def _from_python(table: Any, obj: Any, c: Any) -> Any:
    """Write the fields of a named tuple on the stack; Python keeps its arrays until the call ends."""
    builder, context = c.builder, c.context
    pointer, failed = _new_table(context, builder, table), cgutils.false_bit
    cleanups = []
    for i, (offset, part) in enumerate(zip(_layout(context, table), table.parts, strict=False)):
        model = context.data_model_manager[part]
        place = _field_pointer(builder, pointer, offset, model.get_data_type())
        item = c.pyapi.tuple_getitem(obj, i)
        if isinstance(part, LentArray):
            bytes_ = builder.bitcast(place, _byte_pointer)
            adapt = c.pyapi.nrt_adapt_ndarray_from_python if context.enable_nrt else c.pyapi.numba_array_adaptor
            failed = builder.or_(failed, cgutils.is_not_null(builder, adapt(item, bytes_)))
            cleanups.append((part, place))
        else:
            native = c.unbox(part, item)
            builder.store(model.as_data(builder, native.value), place)
            failed = builder.or_(failed, native.is_error)
            if native.cleanup is not None:
                cleanups.append((native.cleanup, None))

    def give_back() -> None:
        for part, place in cleanups:
            if place is None:
                part()
            elif context.enable_nrt:
                context.nrt.decref(builder, part, builder.load(place))

    return NativeValue(pointer, is_error=failed, cleanup=give_back)


def _layout(context: Any, table: Any) -> list[int]:
    """Return where the fields of a table lie, from its pointer (bytes), and its size."""
    offsets = [0]
    for part in table.parts:
        size = context.get_abi_sizeof(context.get_data_type(part))
        offsets.append(offsets[-1] + -(-size // _WORD) * _WORD)
    return offsets


def _new_table(context: Any, builder: Any, table: Any) -> Any:
    words = ir.ArrayType(_word, max(1, _layout(context, table)[-1] // _WORD))
    return builder.bitcast(cgutils.alloca_once(builder, words), _byte_pointer)


def _field_pointer(builder: Any, table: Any, offset: int, kind: Any) -> Any:
    return builder.bitcast(builder.gep(table, [ir.Constant(_word, offset)], inbounds=True), kind.as_pointer())


def _read(context: Any, builder: Any, table: Any, value: Any, place: int) -> Any:
    part = table.parts[place]
    model = context.data_model_manager[part]
    pointer = _field_pointer(builder, value, _layout(context, table)[place], model.get_data_type())
    if isinstance(part, LentArray):  # in one piece, which takes less code than part by part
        return builder.load(pointer)
    return model.load_from_data_pointer(builder, pointer)
