"""Calls in threads: in order, few at a time, and in the context of the caller."""

import threading
from contextvars import ContextVar

import pytest

from recon.libraries import THREAD_VARIABLES
from recon.threads import in_threads, num_processors, num_threads

given = ContextVar("given", default=0)


@pytest.fixture(params=["1", "3"])
def number(request, monkeypatch):
    monkeypatch.setenv("NUMBA_NUM_THREADS", request.param)
    return int(request.param)


def test_results_are_in_order_and_few_items_are_prefetched(number):
    taken = []

    def items():
        for item in range(20):
            taken.append(item)
            yield item

    results = in_threads(lambda item: item * item, items())
    assert [next(results) for _ in range(5)] == [0, 1, 4, 9, 16]
    assert len(taken) <= 5 + number
    assert list(results) == [item * item for item in range(5, 20)]


def test_calls_share_the_context_and_run_concurrently(number):
    barrier = threading.Barrier(number)
    token = given.set(7)

    def call(item):
        barrier.wait(300)
        return item + given.get()

    assert list(in_threads(call, range(number))) == [item + 7 for item in range(number)]
    given.reset(token)


def test_call_has_one_thread_unless_it_is_the_only_one(monkeypatch):
    monkeypatch.setenv("NUMBA_NUM_THREADS", "3")
    assert list(in_threads(lambda _: num_threads(), range(4))) == [1] * 4
    assert list(in_threads(lambda _: num_threads(), range(2), most=1)) == [3, 3]
    assert num_threads() == 3


def test_exception_of_a_call_is_raised(number):
    with pytest.raises(ZeroDivisionError):
        list(in_threads(lambda item: 1 // item, [1, 0, 1]))


def test_number_of_threads_follows_the_environment(monkeypatch):
    assert "NUMBA_NUM_THREADS" in THREAD_VARIABLES
    monkeypatch.setenv("NUMBA_NUM_THREADS", "3")
    assert num_threads() == 3
    for nonsense in ("", "0", "many"):
        monkeypatch.setenv("NUMBA_NUM_THREADS", nonsense)
        assert num_threads() >= 1


def test_slurm_can_only_reduce_the_number_of_processors(monkeypatch):
    monkeypatch.delenv("NUMBA_NUM_THREADS", raising=False)
    monkeypatch.delenv("SLURM_CPUS_PER_TASK", raising=False)
    bound = num_processors()
    monkeypatch.setenv("SLURM_CPUS_PER_TASK", "1")
    assert num_processors() == num_threads() == 1
    monkeypatch.setenv("SLURM_CPUS_PER_TASK", str(bound + 1))
    assert num_processors() == bound
