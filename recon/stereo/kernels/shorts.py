"""Sixteen small integers at once: the vector type of the semi-global paths.

Costs fit into 16 bits, so that twice as many are processed at a time as with `Lanes`.
"""

import operator
from collections.abc import Callable
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.core.errors import TypingError
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import intrinsic, lower_builtin, models, register_model
from numpy.typing import NDArray

ShortArray = NDArray[np.int16]

NUM_SHORTS = 16

Shorts = Any
"""`NUM_SHORTS` int16, for compiled code only; supports + and -."""

_VECTOR = ir.VectorType(ir.IntType(16), NUM_SHORTS)
_BYTES = 2


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


def _place(context: Any, builder: Any, array_type: Any, array: Any, index: Any) -> Any:
    data = context.make_array(array_type)(context, builder, array).data
    return builder.bitcast(builder.gep(data, [index]), _VECTOR.as_pointer())


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
def spread_short(typing_context: Any, number: Any) -> Any:
    """Shorts that all have the same value."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        number = arguments[0]
        if number.type.width > 16:
            number = builder.trunc(number, ir.IntType(16))
        nothing = ir.Constant(_VECTOR, ir.Undefined)
        first = builder.insert_element(nothing, number, ir.Constant(ir.IntType(32), 0))
        every = ir.Constant(ir.VectorType(ir.IntType(32), NUM_SHORTS), [0] * NUM_SHORTS)
        return builder.shuffle_vector(first, nothing, every)

    return _shorts(number), generate


@intrinsic
def lesser(typing_context: Any, a: Any, b: Any) -> Any:
    """The element-wise minimum."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return _lesser(builder, *arguments)

    return _shorts(_shorts, _shorts), generate


def _lesser(builder: Any, a: Any, b: Any) -> Any:
    return builder.select(builder.icmp_signed("<", a, b), a, b)


def _picked(builder: Any, value: Any, first: int, count: int) -> Any:
    which = ir.Constant(ir.VectorType(ir.IntType(32), count), [first + i for i in range(count)])
    return builder.shuffle_vector(value, ir.Constant(value.type, ir.Undefined), which)


@intrinsic
def least(typing_context: Any, values: Any) -> Any:
    """The smallest of the numbers."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        value, count = arguments[0], NUM_SHORTS // 2
        while count:
            halves = (_picked(builder, value, first, count) for first in (0, count))
            value, count = _lesser(builder, *halves), count // 2
        return builder.extract_element(value, ir.Constant(ir.IntType(32), 0))

    return types.int16(_shorts), generate


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
