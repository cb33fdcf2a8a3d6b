"""What Python has no words for: several candidates compared, kept and sorted by one instruction.

A compiler makes vector instructions of a loop over many candidates, but not of one that writes only some of them
side by side. Written into the module of the search's kernels, as intrinsics.
"""

from __future__ import annotations

from inspect import getsource
from typing import Any

from llvmlite import binding, ir  # type: ignore[import-untyped]
from numba.core import cgutils, types

# Set by the module that the kernels are compiled in.
DIMENSION = 3

WIDE = 8
"""Candidates that are compared with a box at once."""
LANES = 16
"""Candidates that are compared with one particle at once, and rows that are sorted at once."""
ROUNDS = (
    ((0, 1), (2, 3), (4, 5), (6, 7), (8, 9), (10, 11), (12, 13), (14, 15)),
    ((0, 2), (1, 3), (4, 6), (5, 7), (8, 10), (9, 11), (12, 14), (13, 15)),
    ((1, 2), (5, 6), (9, 10), (13, 14)),
    ((0, 4), (1, 5), (2, 6), (3, 7), (8, 12), (9, 13), (10, 14), (11, 15)),
    ((2, 4), (3, 5), (10, 12), (11, 13)),
    ((1, 2), (3, 4), (5, 6), (9, 10), (11, 12), (13, 14)),
    ((0, 8), (1, 9), (2, 10), (3, 11), (4, 12), (5, 13), (6, 14), (7, 15)),
    ((4, 8), (5, 9), (6, 10), (7, 11)),
    ((2, 4), (3, 5), (6, 8), (7, 9), (10, 12), (11, 13)),
    ((1, 2), (3, 4), (5, 6), (7, 8), (9, 10), (11, 12), (13, 14)),
)
"""Batcher's odd-even merge sort of sixteen: the pairs that are put in order in every round."""

_IMPORTS = """from typing import Any
from llvmlite import binding, ir
from numba.core import cgutils, types
from numba.extending import intrinsic"""


def texts() -> list[str]:
    """What a generated module must hold before the intrinsics can be called in it."""
    helpers = (pointer, load, spread, numbers, call, keep)
    return [
        _IMPORTS,
        f"WIDE = {WIDE}\nLANES = {LANES}\nROUNDS = {ROUNDS}",
        *("# run while a kernel is compiled\n" + getsource(f) for f in helpers),
        *("@intrinsic\n" + getsource(f) for f in (keep_near_box, keep_near_point, sort_lanes)),
    ]


def pointer(context: Any, builder: Any, kind: Any, array: Any, index: Any) -> Any:
    """Where a flat array holds the number of this index."""
    return builder.gep(context.make_array(kind)(context, builder, array).data, [index])


def load(builder: Any, place: Any, lanes: int) -> Any:
    """Neighbouring numbers."""
    vector = ir.VectorType(place.type.pointee, lanes)
    size = 8 if isinstance(place.type.pointee, ir.DoubleType) else 4
    return builder.load(builder.bitcast(place, vector.as_pointer()), align=size)


def spread(builder: Any, value: Any, lanes: int) -> Any:
    """The same number in all lanes."""
    vector = ir.VectorType(value.type, lanes)
    first = builder.insert_element(ir.Constant(vector, ir.Undefined), value, ir.IntType(32)(0))
    zeros = ir.Constant(ir.VectorType(ir.IntType(32), lanes), [0] * lanes)
    return builder.shuffle_vector(first, ir.Constant(vector, ir.Undefined), zeros)


def numbers(builder: Any, first: Any, lanes: int) -> Any:
    """first, first + 1, ..."""
    count = ir.Constant(ir.VectorType(first.type, lanes), list(range(lanes)))
    return builder.add(spread(builder, first, lanes), count)


def call(builder: Any, name: str, *arguments: Any) -> Any:
    """LLVM's own function `name` of vectors of one type."""
    vector = arguments[0].type
    kind = "f64" if isinstance(vector.element, ir.DoubleType) else "i32"
    function = ir.FunctionType(vector, [argument.type for argument in arguments])
    full = f"llvm.{name}.v{vector.count}{kind}"
    return builder.call(cgutils.get_or_insert_function(builder.module, function, full), arguments)


def keep(builder: Any, values: Any, mask: Any, place: Any) -> None:
    """Write the lanes that the mask names side by side; behind them, within the number of lanes, anything is left."""
    lanes = values.type.count
    size = 8 if isinstance(values.type.element, ir.DoubleType) else 4
    if binding.llvm_version_info >= (20,):
        nothing = ir.Constant(values.type, ir.Undefined)
        packed = call(builder, "experimental.vector.compress", values, mask, nothing)
        builder.store(packed, builder.bitcast(place, values.type.as_pointer()), align=size)
        return
    for k in range(lanes):
        lane = ir.IntType(32)(k)
        builder.store(builder.extract_element(values, lane), place)
        place = builder.gep(place, [builder.zext(builder.extract_element(mask, lane), ir.IntType(64))])


def keep_near_box(
    typing_context: Any,
    spot: Any, span: Any, row_of: Any, source: Any, end: Any,
    x: Any, x_half: Any, y: Any, y_half: Any, z: Any, z_half: Any, own: Any, begin: Any,
    near_spot: Any, near_span: Any, near_row_of: Any, kept: Any,
) -> Any:  # fmt: skip
    """Keep, of `WIDE` candidates from `source`, those before `end` that `own` reaches from a box; returns how many.

    The box: its middle and half its sides. Rows below `begin` are left out. spot: coordinates and reaches,
    axis by axis, each `span` numbers long.
    """

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        kinds = signature.args
        values = [
            argument if isinstance(kind, types.Array) or kind == types.float64
            else context.cast(builder, argument, kind, types.int64)
            for kind, argument in zip(kinds, arguments, strict=True)
        ]  # fmt: skip
        spot_, span_, row_of_, source_, end_, *box, own_ = values[:12]
        begin_, near_, near_span_, near_row_, kept_ = values[12:]
        zero = ir.Constant(ir.VectorType(ir.DoubleType(), WIDE), [0.0] * WIDE)
        square = zero
        found = []
        axis_place, near_place = source_, kept_
        fused = ("contract",)
        for axis in range(DIMENSION):
            places = load(builder, pointer(context, builder, kinds[0], spot_, axis_place), WIDE)
            found.append((places, near_place))
            apart = builder.fsub(places, spread(builder, box[2 * axis], WIDE))
            apart = builder.fsub(call(builder, "fabs", apart), spread(builder, box[2 * axis + 1], WIDE))
            apart = builder.select(builder.fcmp_ordered(">", apart, zero), apart, zero)
            square = builder.fadd(builder.fmul(apart, apart, flags=fused), square, flags=fused)
            axis_place = builder.add(axis_place, span_)
            near_place = builder.add(near_place, near_span_)
        reaches = load(builder, pointer(context, builder, kinds[0], spot_, axis_place), WIDE)
        found.append((reaches, near_place))
        both = builder.fadd(reaches, spread(builder, own_, WIDE))
        mask = builder.fcmp_ordered("<", square, builder.fmul(both, both))
        rows = load(builder, pointer(context, builder, kinds[2], row_of_, source_), WIDE)
        word = ir.IntType(32)
        late = builder.icmp_signed(">=", rows, spread(builder, builder.trunc(begin_, word), WIDE))
        inside = builder.icmp_signed("<", numbers(builder, source_, WIDE), spread(builder, end_, WIDE))
        mask = builder.and_(builder.and_(mask, inside), late)
        for vector, place in found:
            keep(builder, vector, mask, pointer(context, builder, kinds[13], near_, place))
        keep(builder, rows, mask, pointer(context, builder, kinds[15], near_row_, kept_))
        bits = builder.bitcast(mask, ir.IntType(WIDE))
        return builder.zext(builder.ctpop(bits), ir.IntType(64))

    signature = types.int64(
        spot, span, row_of, source, end, x, x_half, y, y_half, z, z_half, own, begin,
        near_spot, near_span, near_row_of, kept,
    )  # fmt: skip
    return signature, code


def keep_near_point(
    typing_context: Any,
    spot: Any, span: Any, row_of: Any, source: Any, end: Any,
    x: Any, y: Any, z: Any, own: Any, particle: Any, listed: Any, pairs: Any,
) -> Any:  # fmt: skip
    """List, of `LANES` candidates from `source`, the rows of those before `end` that are near to a particle.

    Rows up to `particle`, itself included, are left out. Returns how many were listed.
    """

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        kinds = signature.args
        values = [
            argument if isinstance(kind, types.Array) or kind == types.float64
            else context.cast(builder, argument, kind, types.int64)
            for kind, argument in zip(kinds, arguments, strict=True)
        ]  # fmt: skip
        spot_, span_, row_of_, source_, end_, *point, own_, particle_, listed_, pairs_ = values
        square = None
        place = source_
        fused = ("contract",)
        for axis in range(DIMENSION):
            places = load(builder, pointer(context, builder, kinds[0], spot_, place), LANES)
            apart = builder.fsub(places, spread(builder, point[axis], LANES))
            own_square = builder.fmul(apart, apart, flags=fused)
            square = own_square if square is None else builder.fadd(own_square, square, flags=fused)
            place = builder.add(place, span_)
        reaches = load(builder, pointer(context, builder, kinds[0], spot_, place), LANES)
        both = builder.fadd(reaches, spread(builder, own_, LANES))
        mask = builder.fcmp_ordered("<", square, builder.fmul(both, both))
        rows = load(builder, pointer(context, builder, kinds[2], row_of_, source_), LANES)
        word = ir.IntType(32)
        late = builder.icmp_signed(">", rows, spread(builder, builder.trunc(particle_, word), LANES))
        left = builder.trunc(builder.sub(end_, source_), word)
        inside = builder.icmp_signed("<", numbers(builder, word(0), LANES), spread(builder, left, LANES))
        mask = builder.and_(builder.and_(mask, inside), late)
        keep(builder, rows, mask, pointer(context, builder, kinds[10], listed_, pairs_))
        bits = builder.bitcast(mask, ir.IntType(LANES))
        return builder.zext(builder.ctpop(bits), ir.IntType(64))

    signature = types.int64(
        spot, span, row_of, source, end, x, y, z, own, particle, listed, pairs
    )  # fmt: skip
    return signature, code


def sort_lanes(typing_context: Any, listed: Any, count: Any, near: Any, place: Any) -> Any:
    """near[place : place + count] = the first `count`, at most `LANES`, of listed, ascending.

    Behind them, up to the number of lanes, the largest int32 is written.
    """

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        kinds = signature.args
        word = ir.IntType(32)
        start = ir.IntType(64)(0)
        values = load(builder, pointer(context, builder, kinds[0], arguments[0], start), LANES)
        most = builder.trunc(context.cast(builder, arguments[1], kinds[1], types.int64), word)
        inside = builder.icmp_signed("<", numbers(builder, word(0), LANES), spread(builder, most, LANES))
        values = builder.select(inside, values, spread(builder, word(2**31 - 1), LANES))
        undefined = ir.Constant(values.type, ir.Undefined)
        lanes = ir.VectorType(word, LANES)
        for pairs in ROUNDS:
            partner = list(range(LANES))
            for low, high in pairs:
                partner[low], partner[high] = high, low
            others = builder.shuffle_vector(values, undefined, ir.Constant(lanes, partner))
            least = call(builder, "smin", values, others)
            most_ = call(builder, "smax", values, others)
            choice = [k if partner[k] >= k else LANES + k for k in range(LANES)]
            values = builder.shuffle_vector(least, most_, ir.Constant(lanes, choice))
        index = context.cast(builder, arguments[3], kinds[3], types.int64)
        target = pointer(context, builder, kinds[2], arguments[2], index)
        builder.store(values, builder.bitcast(target, lanes.as_pointer()), align=4)
        return context.get_dummy_value()

    return types.void(listed, count, near, place), code
