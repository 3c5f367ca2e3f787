"""Threads: the same bytes for any number of threads, and no more threads than allowed."""

import threading

import numpy as np
import pytest

from recon.mapping.pair import match_pair
from recon.stereo.kernels.threads import bands, run
from recon.threads import num_processors, num_threads
from scenes import textured_pair


@pytest.mark.parametrize("quality", ["best", "fast"])
def test_number_of_threads_does_not_change_the_bytes(quality, monkeypatch):
    left, right, _ = textured_pair()
    wide = [np.concatenate([image] * 4, axis=1) for image in (left, right)]
    found = {}
    for number in (1, 2, 5):
        monkeypatch.setenv("NUMBA_NUM_THREADS", str(number))
        assert len(bands(wide[0].shape[1], 96)) == number
        found[number] = match_pair(*wide, quality=quality)
    assert len(found[1]) > 1000
    for other in (found[2], found[5]):
        for name in ("points_px", "disparity_px", "sigma_px", "score", "probability"):
            np.testing.assert_array_equal(getattr(other, name), getattr(found[1], name))


def test_bands_cover_everything_once(monkeypatch):
    monkeypatch.setenv("NUMBA_NUM_THREADS", "4")
    for size in (0, 1, 95, 200, 1001):
        rows = [v for first, end in bands(size, 96) for v in range(first, end)]
        assert rows == list(range(size))
    assert len(bands(95, 96)) == 1


def test_bands_have_similar_cost(monkeypatch):
    monkeypatch.setenv("NUMBA_NUM_THREADS", "3")
    cost = np.concatenate([np.zeros(200), np.arange(101.0)])  # the upper 200 rows are empty
    edges = bands(300, 96, cost)
    assert [first for first, _ in edges] == [0, *(end for _, end in edges[:-1])]
    assert edges[-1][1] == 300
    costs = [cost[end] - cost[first] for first, end in edges]
    np.testing.assert_allclose(costs, 100 / 3, atol=1.0)


def test_exception_in_a_thread_is_raised(monkeypatch):
    monkeypatch.setenv("NUMBA_NUM_THREADS", "2")

    def fail():
        raise ValueError("lost")

    assert run([lambda: 1, lambda: 2, lambda: 3]) == [1, 2, 3]
    with pytest.raises(ValueError, match="lost"):
        run([lambda: 1, fail])


def test_tasks_share_threads_that_are_kept(monkeypatch):
    monkeypatch.setenv("NUMBA_NUM_THREADS", "2")
    before = threading.active_count()
    for _ in range(20):
        assert run([num_threads] * 3) == [1, 1, 1]
    assert threading.active_count() <= before + num_processors()
