"""One wire of a block whose numbers lie lane by lane, read and written by the names of its row.

A block is a record with a field ``PREFIX_NAME`` of shape (..., lanes) for each field of a row. Wires in rows are a
row's length apart in memory, so that each number is gathered; here the same number of all lanes is one vector. The
functions of one wire take a lane as they take a row: both have the fields as attributes.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numba.core import cgutils, types
from numba.core.typing.templates import AttributeTemplate
from numba.extending import (
    infer_getattr,
    lower_builtin,
    lower_getattr_generic,
    lower_setattr_generic,
    models,
    register_model,
    type_callable,
)
from numba.np.arrayobj import make_array, populate_array

from musclewire.wire._row import Rows

WIRE, CONSTANTS = "wire_", "constants_"


class Lane:
    """One lane of a block in plain Python, with compilation off."""

    def __init__(self, block: Rows, lane: int, prefix: str) -> None:
        """Look at a lane of the fields with a prefix."""
        vars(self).update(_block=block, _lane=lane, _prefix=prefix)

    def __getattr__(self, name: str) -> Any:
        """Return a number, or a view of an array."""
        return self._block[self._prefix + name][..., self._lane]

    def __setattr__(self, name: str, value: float) -> None:
        """Write a number."""
        self._block[self._prefix + name][..., self._lane] = value


def wire_in(block: Rows, lane: int) -> Any:
    """Return the state of a lane's wire, which is written in place."""
    return Lane(block, lane, WIRE)


def constants_in(block: Rows, lane: int) -> Any:
    """Return the constants of a lane's wire."""
    return Lane(block, lane, CONSTANTS)


def copied(block: Rows, lane: int, row: Rows, prefix: str, *, back: bool) -> None:
    """Copy a row into a lane, or back: the fields that the block has."""
    for name in row.dtype.names:
        if prefix + name in block.dtype.names:
            if back:
                row[name] = block[prefix + name][..., lane]
            else:
                block[prefix + name][..., lane] = row[name]


def take_wire(block: Rows, lane: int, row: Rows) -> None:
    """Copy the row of a wire's state into a lane."""
    copied(block, lane, row, WIRE, back=False)


def take_constants(block: Rows, lane: int, row: Rows) -> None:
    """Copy the row of a wire's constants into a lane, but the tables that a block does not have."""
    copied(block, lane, row, CONSTANTS, back=False)


def give_wire(block: Rows, lane: int, row: Rows) -> None:
    """Copy a lane into the row of its wire's state."""
    copied(block, lane, row, WIRE, back=True)


class LaneType(types.Type):
    """A lane of a block: the block, the place, and which of its fields."""

    def __init__(self, block: types.Record, prefix: str) -> None:
        """Name the type by both."""
        self.block, self.prefix = block, prefix
        super().__init__(name=f"Lane({block}, {prefix})")

    def shape_of(self, attribute: str) -> tuple[int, ...] | None:
        """Return a field's shape in one lane; None for an unknown field."""
        name = self.prefix + attribute
        return self.block.typeof(name).shape[:-1] if name in self.block.fields else None


@register_model(LaneType)
class LaneModel(models.StructModel):
    """A lane in memory: a pointer to the block, and the place."""

    def __init__(self, manager: Any, kind: LaneType) -> None:
        """List both."""
        super().__init__(manager, kind, [("block", kind.block), ("lane", types.intp)])


@infer_getattr
class LaneAttributes(AttributeTemplate):
    """The types of a lane's attributes."""

    key = LaneType

    def generic_resolve(self, kind: LaneType, attribute: str) -> Any:
        """Return the type of a number or of an array; None for an unknown field."""
        shape = kind.shape_of(attribute)
        if shape is None:
            return None
        return types.Array(types.float64, len(shape), "A") if shape else types.float64


def lane_with(function: Callable[..., Any], prefix: str) -> None:
    """Compile a function of a block and a lane as the lane of the fields with a prefix."""

    @type_callable(function)
    def type_of_lane(_context: Any) -> Any:
        return lambda block, _lane: LaneType(block, prefix) if isinstance(block, types.Record) else None

    @lower_builtin(function, types.Record, types.Integer)
    def lowered(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        found = cgutils.create_struct_proxy(signature.return_type)(context, builder)
        found.block = arguments[0]
        found.lane = context.cast(builder, arguments[1], signature.args[1], types.intp)
        return found._getvalue()


lane_with(wire_in, WIRE)
lane_with(constants_in, CONSTANTS)


def address(context: Any, builder: Any, block: types.Record, pointer: Any, name: str, lane: Any) -> Any:
    """Return the address of a field's first number in a lane."""
    double = context.get_data_type(types.float64)
    return builder.gep(cgutils.get_record_member(builder, pointer, block.offset(name), double), [lane], inbounds=True)


@lower_getattr_generic(LaneType)
def attribute_of(context: Any, builder: Any, kind: LaneType, value: Any, attribute: str) -> Any:
    """Load a number, or return a view of an array whose numbers are a block's lanes apart."""
    lane = cgutils.create_struct_proxy(kind)(context, builder, value)
    name = kind.prefix + attribute
    first = address(context, builder, kind.block, lane.block, name, lane.lane)
    shape = kind.shape_of(attribute)
    if not shape:
        return builder.load(first)
    apart = 8 * kind.block.typeof(name).shape[-1]
    array = make_array(types.Array(types.float64, 1, "A"))(context, builder)
    place = context.get_constant
    populate_array(
        array,
        data=first,
        shape=cgutils.pack_array(builder, [place(types.intp, shape[0])]),
        strides=cgutils.pack_array(builder, [place(types.intp, apart)]),
        itemsize=place(types.intp, 8),
        meminfo=None,
        parent=None,
    )
    return array._getvalue()


@lower_setattr_generic(LaneType)
def set_attribute_of(context: Any, builder: Any, signature: Any, arguments: Any, attribute: str) -> None:
    """Store a number."""
    kind, given = signature.args
    lane = cgutils.create_struct_proxy(kind)(context, builder, arguments[0])
    number = context.cast(builder, arguments[1], given, types.float64)
    builder.store(number, address(context, builder, kind.block, lane.block, kind.prefix + attribute, lane.lane))


def copy_with(function: Callable[..., Any], prefix: str, *, back: bool) -> None:
    """Compile a function of a block, a lane and a row as the copy of all fields that both have, number by number."""

    @type_callable(function)
    def type_of_copy(_context: Any) -> Any:
        return lambda block, _lane, _row: types.none if isinstance(block, types.Record) else None

    @lower_builtin(function, types.Record, types.Integer, types.Record)
    def lowered(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        block, given, row = signature.args
        lane = context.cast(builder, arguments[1], given, types.intp)
        for name in row.fields:
            if prefix + name not in block.fields:
                continue
            inside = address(context, builder, block, arguments[0], prefix + name, lane)
            double = context.get_data_type(types.float64)
            outside = cgutils.get_record_member(builder, arguments[2], row.offset(name), double)
            apart, kind = block.typeof(prefix + name).shape[-1], row.typeof(name)
            for number in range(kind.shape[0] if isinstance(kind, types.NestedArray) else 1):
                place = context.get_constant
                ends = (
                    builder.gep(inside, [place(types.intp, number * apart)], inbounds=True),
                    builder.gep(outside, [place(types.intp, number)], inbounds=True),
                )
                source, target = ends if back else ends[::-1]
                builder.store(builder.load(source), target)
        return context.get_dummy_value()


copy_with(take_wire, WIRE, back=False)
copy_with(take_constants, CONSTANTS, back=False)
copy_with(give_wire, WIRE, back=True)
