"""Lanes stored in half precision: half the memory, for numbers that need not be exact."""

from typing import Any

import numpy as np
from llvmlite import ir
from llvmlite.binding import get_host_cpu_features
from numba import types
from numba.extending import intrinsic
from numpy.typing import NDArray

from recon.stereo.kernels.simd import NUM_LANES, VECTOR, check_array, lanes_type, place_of

Halves = NDArray[np.uint16]
"""Numbers of half precision, by their bits: numba has no type for them."""

_HALVES, _SHORTS, _INTS = (
    ir.VectorType(item, NUM_LANES) for item in (ir.HalfType(), ir.IntType(16), ir.IntType(32))
)
_HALF_BYTES = 2
_CONVERTS_HALVES = get_host_cpu_features().get("f16c", True)
"""False for old or emulated x86 processors, where LLVM would call a function that is not there."""
_MISSING_BITS, _MISSING_BIAS = 13, 112
"""Bits of the fraction and bias of the exponent that a half lacks of a float."""


@intrinsic
def load_halves(typing_context: Any, array: Any, index: Any) -> Any:
    """The lanes ``array[index : index + NUM_LANES]`` of a contiguous array of half precision."""
    check_array(array, types.uint16)

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        place = place_of(_SHORTS, context, builder, signature.args[0], *arguments)
        return _widened(builder, builder.load(place, align=_HALF_BYTES))

    return lanes_type(array, types.intp), generate


@intrinsic
def store_halves(typing_context: Any, array: Any, index: Any, value: Any) -> Any:
    """Write lanes >= 0 to ``array[index : index + NUM_LANES]`` of a contiguous array of halves."""
    check_array(array, types.uint16)

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        place = place_of(_SHORTS, context, builder, signature.args[0], *arguments[:2])
        builder.store(_narrowed(builder, arguments[2]), place, align=_HALF_BYTES)
        return context.get_dummy_value()

    return types.void(array, types.intp, lanes_type), generate


def _widened(builder: Any, halves: Any) -> Any:
    """Halves as lanes, by their bits where the processor does not convert them."""
    if _CONVERTS_HALVES:
        return builder.fpext(builder.bitcast(halves, _HALVES), VECTOR)
    bits = builder.shl(builder.zext(halves, _INTS), _constant(_INTS, _MISSING_BITS))
    return builder.fmul(builder.bitcast(bits, VECTOR), _constant(VECTOR, 2.0**_MISSING_BIAS))


def _narrowed(builder: Any, lanes: Any) -> Any:
    """Lanes as halves, rounded to the nearest, to even ones in the middle."""
    if _CONVERTS_HALVES:
        return builder.bitcast(builder.fptrunc(lanes, _HALVES), _SHORTS)
    low = builder.fmul(lanes, _constant(VECTOR, 2.0**-_MISSING_BIAS))
    bits, gone = builder.bitcast(low, _INTS), _constant(_INTS, _MISSING_BITS)
    odd = builder.and_(builder.lshr(bits, gone), _constant(_INTS, 1))
    half = _constant(_INTS, (1 << (_MISSING_BITS - 1)) - 1)
    rounded = builder.add(bits, builder.add(odd, half))
    return builder.trunc(builder.lshr(rounded, gone), _SHORTS)


def _constant(vector: Any, value: float) -> Any:
    return ir.Constant(vector, [value] * NUM_LANES)
