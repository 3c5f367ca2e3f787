"""Lanes and shorts compute on many numbers what Python computes on one."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numba import njit
from numba.core.errors import TypingError

from recon.stereo.kernels import memory, shorts
from recon.stereo.kernels import simd as lanes
from recon.stereo.kernels.memory import aligned_zeros, reused_empty
from recon.stereo.kernels.shorts import (
    NUM_SHORTS,
    WHOLE,
    greater,
    greatest,
    least,
    lesser,
    load_shorts,
    part,
    rounded,
    short_earlier,
    short_later,
    store_rounded,
    store_shorts,
)
from recon.stereo.kernels.simd import (
    NUM_LANES,
    kernel,
    larger,
    largest,
    load,
    repeat,
    smaller,
    spread,
    store,
    total,
)

numbers = arrays(np.float32, 2 * NUM_LANES, elements=st.floats(-100, 100, width=16))


@kernel
def calculate(a, b, out):
    for i in range(0, a.size, NUM_LANES):
        x, y = load(a, i), load(b, i)
        x += 2 * y
        store(out, i, smaller(x - y, repeat(b, 3)) * larger(x, y) / spread(4.0))


@kernel
def reduce(a):
    return largest(load(a, 1)), total(load(a, 1))


@settings(max_examples=50)
@given(numbers, numbers)
def test_arithmetic_matches_arrays(a, b):
    out = np.zeros_like(a)
    calculate(a, b, out)
    x = a + 2 * b
    wanted = np.minimum(x - b, b[3]) * np.maximum(x, b) / 4
    np.testing.assert_allclose(out, wanted, rtol=1e-5, atol=1e-3)


@settings(max_examples=50)
@given(numbers)
def test_reductions_use_every_number_once(a):
    highest, added = reduce(a)
    assert highest == a[1 : 1 + NUM_LANES].max()
    assert added == pytest.approx(a[1 : 1 + NUM_LANES].sum(dtype=float), abs=1e-3)


def test_store_writes_exactly_eight_numbers():
    @njit
    def write(out):
        store(out, 3, spread(7.0))

    out = np.zeros(20, np.float32)
    write(out)
    np.testing.assert_array_equal(np.flatnonzero(out), np.arange(3, 3 + NUM_LANES))


@pytest.mark.parametrize(
    "array",
    [np.zeros(16), np.zeros((2, 8), np.float32), np.zeros(32, np.float32)[::2]],
    ids=["float64", "two axes", "gaps"],
)
def test_only_rows_of_floats_compile(array):
    @njit
    def read(array):
        return total(load(array, 0))

    with pytest.raises(TypingError, match="is not a contiguous \\(N,\\) float32 array"):
        read(array)


@pytest.mark.parametrize(
    ("size", "whole", "wanted"), [(0, 8, 0), (1, 8, 8), (16, 8, 16), (17, 16, 32)]
)
def test_filled_rounds_up_to_the_next_multiple(size, whole, wanted):
    assert lanes.filled(size, whole) == wanted


@pytest.mark.parametrize("size", [1, 37, 5000])
def test_arrays_are_aligned_to_cache_lines(size):
    room = aligned_zeros(size)
    assert room.shape == (size,)
    assert room.ctypes.data % 64 == 0
    assert not room.any()


@kernel
def round_off(a, out):
    for i in range(0, a.size, NUM_LANES):
        store_rounded(out[0], i, load(a, i))
    for i in range(0, a.size, NUM_SHORTS):
        store_shorts(out[1], i, rounded(load(a, i), load(a, i + NUM_LANES)))


@settings(max_examples=20)
@given(arrays(np.float32, 2 * NUM_SHORTS, elements=st.floats(0, 32_000, width=32)))
def test_lanes_become_the_nearest_shorts(a):
    out = np.zeros((2, a.size), np.int16)
    round_off(a, out)
    np.testing.assert_array_equal(out, [np.floor(a + np.float32(0.5))] * 2)


short_numbers = arrays(np.int16, NUM_SHORTS)


def multiplied_by_hand(monkeypatch):
    monkeypatch.setattr(shorts, "_MULTIPLIES_SHARES", False)


@pytest.mark.parametrize("prepare", [lambda _: None, multiplied_by_hand])
def test_parts_are_rounded_products(prepare, monkeypatch):
    prepare(monkeypatch)

    @njit
    def multiply(a, b, out):
        for i in range(0, a.size, NUM_SHORTS):
            store_shorts(out, i, part(load_shorts(a, i), load_shorts(b, i)))

    a, b = np.random.default_rng(5).integers(-WHOLE + 1, WHOLE, (2, 80_000)).astype(np.int16)
    out = np.zeros_like(a)
    multiply(a, b, out)
    np.testing.assert_array_equal(out, (a.astype(int) * b + WHOLE // 2) // WHOLE)


@kernel
def slide(a, out):
    store_shorts(out, 0, short_earlier(load_shorts(a, 0), load_shorts(a, NUM_SHORTS)))
    store_shorts(out, NUM_SHORTS, short_later(load_shorts(a, 0), load_shorts(a, NUM_SHORTS)))


@settings(max_examples=20)
@given(arrays(np.int16, 2 * NUM_SHORTS))
def test_neighbours_match_a_shifted_load(a):
    out = np.zeros_like(a)
    slide(a, out)
    np.testing.assert_array_equal(out[:NUM_SHORTS], a[NUM_SHORTS - 1 : -1])
    np.testing.assert_array_equal(out[NUM_SHORTS:], a[1 : NUM_SHORTS + 1])


@kernel
def reduce_shorts(a, b, out):
    x, y = load_shorts(a, 0), load_shorts(b, 0)
    store_shorts(out[0], 0, lesser(x, y))
    store_shorts(out[1], 0, greater(x, y))
    return least(x), greatest(x)


@settings(max_examples=20)
@given(short_numbers, short_numbers)
def test_extremes_of_shorts_match_arrays(a, b):
    out = np.zeros((2, NUM_SHORTS), np.int16)
    assert reduce_shorts(a, b, out) == (a.min(), a.max())
    np.testing.assert_array_equal(out, [np.minimum(a, b), np.maximum(a, b)])


def test_freed_memory_of_the_same_size_is_used_again(monkeypatch):
    monkeypatch.setattr(memory, "_SMALLEST_LENT", 0)
    first = reused_empty((3, 5, 7))
    place, view = first.ctypes.data, first[1:]
    del first
    other = reused_empty((3, 5, 7))
    assert other.ctypes.data != place  # the view still uses it
    del view
    assert reused_empty((105,)).ctypes.data == place
    assert reused_empty((3, 5, 7, 2)).shape == (3, 5, 7, 2)
