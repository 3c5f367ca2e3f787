"""Eight numbers at once: the vector type of the inner loops of stereo.

The compiler vectorises simple loops by itself, but not those that read or write many possibly
overlapping streams, as the filters do. Kernels written with `Lanes` always compile to vector
instructions.
"""

import operator
from collections.abc import Callable
from typing import Any

import numpy as np
from llvmlite import ir
from numba import njit, types
from numba.core.errors import TypingError
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import intrinsic, lower_builtin, models, register_model
from numpy.typing import NDArray

Floats = NDArray[np.float32]
Integers = NDArray[np.int64]

NUM_LANES = 8
FAST = {"contract", "nsz", "nnan"}
"""Permitted floating-point optimisations: none that changes from run to run."""

kernel = njit(cache=True, fastmath=FAST, error_model="numpy", _nrt=False, forceinline=True)
"""Compiles loops that allocate nothing. They do not count references to views: each count would be
a locked instruction, a fifth of the time of a whole pair."""
kernel_with_nan = njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
"""Like `kernel`, but for numbers that may be NaN."""

Lanes = Any
"""`NUM_LANES` float32, for compiled code only; supports +, -, * and /."""

VECTOR = ir.VectorType(ir.FloatType(), NUM_LANES)
_FLOAT_BYTES = 4
_READ_INTO_L2_DATA = (0, 2, 1)
"""Arguments of LLVM's prefetch: for reading, into the second level, of data."""


class _LanesType(types.Type):  # type: ignore[misc]
    """numba's name for the vector."""

    def __init__(self) -> None:
        super().__init__(name=f"Lanes({NUM_LANES})")


lanes_type = _LanesType()


@register_model(_LanesType)
class _LanesModel(models.PrimitiveModel):  # type: ignore[misc]
    """The vector is a native machine value."""

    def __init__(self, manager: Any, numba_type: _LanesType) -> None:
        super().__init__(manager, numba_type, VECTOR)


def filled(size: int, whole: int = NUM_LANES) -> int:
    """`size` rounded up to whole lanes, or to another multiple."""
    return -(-size // whole) * whole


def check_array(array: Any, item: Any = types.float32) -> None:
    """Refuse arrays with another item size or with gaps."""
    is_flat = isinstance(array, types.Array) and array.ndim == 1 and array.layout == "C"
    if not is_flat or array.dtype != item:
        raise TypingError(f"{array} is not a contiguous (N,) {item} array, as lanes need")


def place_of(
    vector: Any, context: Any, builder: Any, array_type: Any, array: Any, index: Any
) -> Any:
    """Pointer to the lanes that begin at an entry of a flat array."""
    data = context.make_array(array_type)(context, builder, array).data
    return builder.bitcast(builder.gep(data, [index]), vector.as_pointer())


@intrinsic
def load(typing_context: Any, array: Any, index: Any) -> Any:
    """The lanes ``array[index : index + NUM_LANES]`` of a contiguous (N,) float32 array."""

    check_array(array)

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        place = place_of(VECTOR, context, builder, signature.args[0], *arguments)
        return builder.load(place, align=_FLOAT_BYTES)

    return lanes_type(array, types.intp), generate


@intrinsic
def store(typing_context: Any, array: Any, index: Any, value: Any) -> Any:
    """Write lanes to ``array[index : index + NUM_LANES]`` of a contiguous (N,) float32 array."""

    check_array(array)

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        place = place_of(VECTOR, context, builder, signature.args[0], *arguments[:2])
        builder.store(arguments[2], place, align=_FLOAT_BYTES)
        return context.get_dummy_value()

    return types.void(array, types.intp, lanes_type), generate


@intrinsic
def spread(typing_context: Any, number: Any) -> Any:
    """Lanes that all have the same value."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return _spread(builder, arguments[0])

    return lanes_type(types.float32), generate


def _spread(builder: Any, number: Any) -> Any:
    nothing = ir.Constant(VECTOR, ir.Undefined)
    first = builder.insert_element(nothing, number, ir.Constant(ir.IntType(32), 0))
    every = ir.Constant(ir.VectorType(ir.IntType(32), NUM_LANES), [0] * NUM_LANES)
    return builder.shuffle_vector(first, nothing, every)


@intrinsic
def repeat(typing_context: Any, array: Any, index: Any) -> Any:
    """Lanes that all have the value of one entry of a contiguous (N,) float32 array."""

    check_array(array)

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
        return _spread(builder, builder.load(builder.gep(data, [arguments[1]])))

    return lanes_type(array, types.intp), generate


@intrinsic
def prefetch(typing_context: Any, array: Any, index: Any) -> Any:
    """Hint that an entry of a flat float32 array will be read soon; it may lie outside."""
    check_array(array)

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
        place = builder.bitcast(builder.gep(data, [arguments[1]]), ir.IntType(8).as_pointer())
        number = ir.IntType(32)
        hint = builder.module.declare_intrinsic(
            "llvm.prefetch",
            [place.type],
            ir.FunctionType(ir.VoidType(), [place.type, *[number] * 3]),
        )
        builder.call(hint, [place, *(ir.Constant(number, k) for k in _READ_INTO_L2_DATA)])
        return context.get_dummy_value()

    return types.void(array, types.intp), generate


def _picked(builder: Any, value: Any, first: int, count: int) -> Any:
    """Some of the numbers of a vector."""
    which = ir.Constant(ir.VectorType(ir.IntType(32), count), [first + i for i in range(count)])
    return builder.shuffle_vector(value, ir.Constant(value.type, ir.Undefined), which)


def reduction(
    combine: Callable[..., Any], vector: Any, number: Any, size: int
) -> Callable[..., Any]:
    """Reduction of all numbers of a vector to one, by halves."""

    def reduce(typing_context: Any, values: Any) -> Any:
        def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            value, count = arguments[0], size // 2
            while count:
                halves = (_picked(builder, value, first, count) for first in (0, count))
                value, count = combine(builder, *halves), count // 2
            return builder.extract_element(value, ir.Constant(ir.IntType(32), 0))

        return number(vector), generate

    reduced: Callable[..., Any] = intrinsic(reduce)
    return reduced


def _choice(comparison: str) -> Callable[..., Any]:
    """The element-wise minimum or maximum, by a comparison."""

    def choose(typing_context: Any, a: Any, b: Any) -> Any:
        def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            return _select(comparison, builder, *arguments)

        return lanes_type(lanes_type, lanes_type), generate

    chosen: Callable[..., Any] = intrinsic(choose)
    return chosen


def _select(comparison: str, builder: Any, a: Any, b: Any) -> Any:
    return builder.select(builder.fcmp_ordered(comparison, a, b), a, b)


smaller = _choice("<")
larger = _choice(">")
largest = reduction(
    lambda builder, a, b: _select(">", builder, a, b), lanes_type, types.float32, NUM_LANES
)
total = reduction(lambda builder, a, b: builder.fadd(a, b), lanes_type, types.float32, NUM_LANES)


def _compile_operator(symbol: Callable[..., Any], instruction: str) -> None:
    """Compile an operator on lanes, or on a number and lanes, to an instruction."""

    class Template(AbstractTemplate):  # type: ignore[misc]
        def generic(self, arguments: Any, keywords: Any) -> Any:
            first, second = arguments
            if second == lanes_type and (first == lanes_type or isinstance(first, types.Number)):
                return signature(
                    lanes_type, lanes_type if first == lanes_type else types.float32, lanes_type
                )
            return None

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return getattr(builder, instruction)(*arguments)

    def generate_spread(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return getattr(builder, instruction)(_spread(builder, arguments[0]), arguments[1])

    infer_global(symbol)(Template)
    lower_builtin(symbol, lanes_type, lanes_type)(generate)
    lower_builtin(symbol, types.float32, lanes_type)(generate_spread)


_compile_operator(operator.add, "fadd")
_compile_operator(operator.iadd, "fadd")
_compile_operator(operator.sub, "fsub")
_compile_operator(operator.mul, "fmul")
_compile_operator(operator.truediv, "fdiv")
