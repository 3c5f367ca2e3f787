"""Sixteen small integers at once: the vector type of the semi-global paths and of votes.

Costs and shares fit into 16 bits, so that twice as many are processed at a time as with `Lanes`.
"""

import operator
from collections.abc import Callable
from typing import Any

import numpy as np
from llvmlite import ir
from llvmlite.binding import get_host_cpu_features
from numba import types
from numba.core.errors import TypingError
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import intrinsic, lower_builtin, models, register_model
from numpy.typing import NDArray

from recon.stereo.kernels.simd import NUM_LANES, VECTOR, lanes_type, reduction

ShortArray = NDArray[np.int16]

NUM_SHORTS = 16

Shorts = Any
"""`NUM_SHORTS` int16, for compiled code only; supports + and -."""

_VECTOR = ir.VectorType(ir.IntType(16), NUM_SHORTS)
_BYTES = 2
_LANE_INTEGERS = ir.VectorType(ir.IntType(32), NUM_LANES)
_LANE_SHORTS = ir.VectorType(ir.IntType(16), NUM_LANES)

WHOLE = 1 << 15
"""The share 1; as a short, one less."""
_MULTIPLIES_SHARES = get_host_cpu_features().get("avx2", False)
"""True if the processor has the instruction that multiplies by a share."""


class _ShortsType(types.Type):  # type: ignore[misc]
    """numba's name for the vector."""

    def __init__(self) -> None:
        super().__init__(name=f"Shorts({NUM_SHORTS})")


_shorts = _ShortsType()


@register_model(_ShortsType)
class _ShortsModel(models.PrimitiveModel):  # type: ignore[misc]
    """The vector is a native machine value."""

    def __init__(self, manager: Any, numba_type: _ShortsType) -> None:
        super().__init__(manager, numba_type, _VECTOR)


def _check_array(array: Any) -> None:
    is_flat = isinstance(array, types.Array) and array.ndim == 1 and array.layout == "C"
    if not is_flat or array.dtype != types.int16:
        raise TypingError(f"{array} is not a contiguous (N,) int16 array, as shorts need")


def _place(
    context: Any, builder: Any, array_type: Any, array: Any, index: Any, vector: Any = _VECTOR
) -> Any:
    data = context.make_array(array_type)(context, builder, array).data
    return builder.bitcast(builder.gep(data, [index]), vector.as_pointer())


@intrinsic
def load_shorts(typing_context: Any, array: Any, index: Any) -> Any:
    """The entries ``array[index : index + NUM_SHORTS]`` of a contiguous (N,) int16 array."""
    _check_array(array)

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        place = _place(context, builder, signature.args[0], *arguments)
        return builder.load(place, align=_BYTES)

    return _shorts(array, types.intp), generate


@intrinsic
def store_shorts(typing_context: Any, array: Any, index: Any, value: Any) -> Any:
    """Write ``array[index : index + NUM_SHORTS]`` of a contiguous (N,) int16 array."""
    _check_array(array)

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        place = _place(context, builder, signature.args[0], *arguments[:2])
        builder.store(arguments[2], place, align=_BYTES)
        return context.get_dummy_value()

    return types.void(array, types.intp, _shorts), generate


@intrinsic
def store_rounded(typing_context: Any, array: Any, index: Any, value: Any) -> Any:
    """Write lanes from 0 to 32767, rounded, to ``array[index : index + NUM_LANES]``."""
    _check_array(array)

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        array, index, lanes = arguments
        place = _place(context, builder, signature.args[0], array, index, _LANE_SHORTS)
        builder.store(builder.trunc(_whole(builder, lanes), _LANE_SHORTS), place, align=_BYTES)
        return context.get_dummy_value()

    return types.void(array, types.intp, lanes_type), generate


@intrinsic
def rounded(typing_context: Any, first: Any, second: Any) -> Any:
    """Shorts of the numbers, from 0 to 32767, of two lanes."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        both = (_whole(builder, lanes) for lanes in arguments)
        every = ir.Constant(ir.VectorType(ir.IntType(32), NUM_SHORTS), list(range(NUM_SHORTS)))
        return builder.trunc(builder.shuffle_vector(*both, every), _VECTOR)

    return _shorts(lanes_type, lanes_type), generate


def _whole(builder: Any, lanes: Any) -> Any:
    half = ir.Constant(VECTOR, [0.5] * NUM_LANES)
    return builder.fptosi(builder.fadd(lanes, half), _LANE_INTEGERS)


@intrinsic
def spread_short(typing_context: Any, number: Any) -> Any:
    """Shorts that all have the same value."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return _spread(builder, arguments[0])

    return _shorts(number), generate


def _spread(builder: Any, number: Any) -> Any:
    if number.type.width > 16:
        number = builder.trunc(number, ir.IntType(16))
    nothing = ir.Constant(_VECTOR, ir.Undefined)
    first = builder.insert_element(nothing, number, ir.Constant(ir.IntType(32), 0))
    every = ir.Constant(ir.VectorType(ir.IntType(32), NUM_SHORTS), [0] * NUM_SHORTS)
    return builder.shuffle_vector(first, nothing, every)


def _of_two(combine: Callable[..., Any]) -> Callable[..., Any]:
    """An element-wise operation on two vectors."""

    def both(typing_context: Any, a: Any, b: Any) -> Any:
        def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            return combine(builder, *arguments)

        return _shorts(_shorts, _shorts), generate

    operation: Callable[..., Any] = intrinsic(both)
    return operation


def _lesser(builder: Any, a: Any, b: Any) -> Any:
    return builder.select(builder.icmp_signed("<", a, b), a, b)


def _greater(builder: Any, a: Any, b: Any) -> Any:
    return builder.select(builder.icmp_signed(">", a, b), a, b)


def _part(builder: Any, a: Any, b: Any) -> Any:
    """``(a * b + WHOLE / 2) // WHOLE``."""
    if _MULTIPLIES_SHARES:
        kind = ir.FunctionType(_VECTOR, [_VECTOR, _VECTOR])
        multiply = builder.module.declare_intrinsic("llvm.x86.avx2.pmul.hr.sw", (), kind)
        return builder.call(multiply, [a, b])
    wide = ir.VectorType(ir.IntType(32), NUM_SHORTS)
    product = builder.mul(builder.sext(a, wide), builder.sext(b, wide))
    product = builder.add(product, ir.Constant(wide, [WHOLE // 2] * NUM_SHORTS))
    return builder.trunc(builder.ashr(product, ir.Constant(wide, [15] * NUM_SHORTS)), _VECTOR)


def _slide(first: int) -> Callable[..., Any]:
    """Neighbours among the numbers of two vectors, from the number `first` on."""
    numbers = ir.VectorType(ir.IntType(32), NUM_SHORTS)
    mask = ir.Constant(numbers, [first + i for i in range(NUM_SHORTS)])
    return _of_two(lambda builder, a, b: builder.shuffle_vector(a, b, mask))


short_earlier = _slide(NUM_SHORTS - 1)
"""From shorts and those that follow: the latter, each replaced by the number before it."""
short_later = _slide(1)
"""From shorts and those that follow: the former, each replaced by the number after it."""
lesser = _of_two(_lesser)
"""The minimum of each two numbers."""
greater = _of_two(_greater)
"""The maximum of each two numbers."""
part = _of_two(_part)
"""Numbers times shares of `WHOLE`, rounded."""


least = reduction(_lesser, _shorts, types.int16, NUM_SHORTS)
"""The smallest of the numbers."""
greatest = reduction(_greater, _shorts, types.int16, NUM_SHORTS)
"""The largest of the numbers."""


@intrinsic
def first_equal(typing_context: Any, values: Any, number: Any) -> Any:
    """Place of the first of the numbers that equals another; `NUM_SHORTS` if none does."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        integer = ir.IntType(64)
        equal = builder.icmp_signed("==", arguments[0], _spread(builder, arguments[1]))
        bits = builder.zext(builder.bitcast(equal, ir.IntType(NUM_SHORTS)), integer)
        beyond = builder.or_(bits, ir.Constant(integer, 1 << NUM_SHORTS))
        return builder.cttz(beyond, ir.Constant(ir.IntType(1), 1))

    return types.int64(_shorts, number), generate


def _compile_operator(symbol: Callable[..., Any], instruction: str) -> None:
    """Compile an operator on two vectors to an instruction."""

    class Template(AbstractTemplate):  # type: ignore[misc]
        def generic(self, arguments: Any, keywords: Any) -> Any:
            both = tuple(arguments) == (_shorts, _shorts)
            return signature(_shorts, _shorts, _shorts) if both else None

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return getattr(builder, instruction)(*arguments)

    infer_global(symbol)(Template)
    lower_builtin(symbol, _shorts, _shorts)(generate)


_compile_operator(operator.add, "add")
_compile_operator(operator.iadd, "add")
_compile_operator(operator.sub, "sub")
