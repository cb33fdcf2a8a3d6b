"""What Python has no words for: four neighbouring numbers in one instruction, and asking for memory ahead of time.

The compiler works on several numbers of one row at once only when numba's SLP pass is on, and with that pass the
loop over blocks runs at half its speed. Written into the module of a kernel like the functions of
`geodem.kernels.pairs`, as intrinsics.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir  # type: ignore[import-untyped]
from numba.core import types

from .._jit import function_source

_IMPORTS = """from typing import Any
from llvmlite import ir
from numba.core import types
from numba.extending import intrinsic"""


def texts() -> list[str]:
    """What a generated module must hold before `add_fours`, `subtract_fours` and `fetch` can be called in it."""
    helpers = ["# run while a kernel is compiled\n" + function_source(f) for f in (four_at, combine_fours)]
    return [
        _IMPORTS,
        *helpers,
        *("@intrinsic\n" + function_source(f) for f in (add_fours, subtract_fours, fetch)),
    ]


def four_at(context: Any, builder: Any, array_type: Any, array: Any, index_type: Any, index: Any) -> Any:
    """Pointer to the four numbers from `index` of a flat array."""
    data = context.make_array(array_type)(context, builder, array).data
    place = builder.gep(data, [context.cast(builder, index, index_type, types.intp)])
    return builder.bitcast(place, ir.VectorType(ir.DoubleType(), 4).as_pointer())


def combine_fours(context: Any, builder: Any, signature: Any, arguments: Any, operation: str) -> Any:
    """Code of target[t : t + 4] = first[f : f + 4] (+ or -) second[s : s + 4]."""
    kinds = signature.args
    target, first, second = (
        four_at(context, builder, kinds[k], arguments[k], kinds[k + 1], arguments[k + 1]) for k in (0, 2, 4)
    )
    four = ir.VectorType(ir.DoubleType(), 4)
    result = getattr(builder, operation)(
        builder.load(first, align=8, typ=four), builder.load(second, align=8, typ=four)
    )
    builder.store(result, target, align=8)
    return context.get_dummy_value()


def add_fours(typing_context: Any, target: Any, t: Any, first: Any, f: Any, second: Any, s: Any) -> Any:
    """target[t : t + 4] = first[f : f + 4] + second[s : s + 4], of flat arrays."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return combine_fours(context, builder, signature, arguments, "fadd")

    return types.void(target, t, first, f, second, s), code


def subtract_fours(typing_context: Any, target: Any, t: Any, first: Any, f: Any, second: Any, s: Any) -> Any:
    """target[t : t + 4] = first[f : f + 4] - second[s : s + 4], of flat arrays."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return combine_fours(context, builder, signature, arguments, "fsub")

    return types.void(target, t, first, f, second, s), code


def fetch(typing_context: Any, array: Any, index: Any) -> Any:
    """Ask for the line of the cache that holds `index` of a flat array, without waiting for it."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        kinds = signature.args
        data = context.make_array(kinds[0])(context, builder, arguments[0]).data
        place = builder.gep(data, [context.cast(builder, arguments[1], kinds[1], types.intp)])
        byte = ir.IntType(8).as_pointer()
        word = ir.IntType(32)
        function = builder.module.declare_intrinsic(
            "llvm.prefetch", [byte], ir.FunctionType(ir.VoidType(), [byte, word, word, word])
        )
        builder.call(function, [builder.bitcast(place, byte), word(0), word(3), word(1)])
        return context.get_dummy_value()

    return types.void(array, index), code
