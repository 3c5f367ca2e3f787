"""Calls in threads: in order, few at a time, and with what their caller set."""

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


def test_results_come_in_order_and_few_items_are_taken_ahead(number):
    taken = []

    def items():
        for item in range(20):
            taken.append(item)
            yield item

    results = in_threads(lambda item: item * item, items())
    assert [next(results) for _ in range(5)] == [0, 1, 4, 9, 16]
    assert len(taken) <= 5 + number
    assert list(results) == [item * item for item in range(5, 20)]


def test_calls_see_the_context_and_run_side_by_side(number):
    barrier = threading.Barrier(number)
    token = given.set(7)

    def call(item):
        barrier.wait(10)
        return item + given.get()

    assert list(in_threads(call, range(number))) == [item + 7 for item in range(number)]
    given.reset(token)


def test_a_call_has_one_thread_unless_it_is_the_only_one(monkeypatch):
    monkeypatch.setenv("NUMBA_NUM_THREADS", "3")
    assert list(in_threads(lambda _: num_threads(), range(4))) == [1] * 4
    assert list(in_threads(lambda _: num_threads(), range(2), most=1)) == [3, 3]
    assert num_threads() == 3


def test_what_a_call_raises_is_raised(number):
    with pytest.raises(ZeroDivisionError):
        list(in_threads(lambda item: 1 // item, [1, 0, 1]))


def test_the_allowance_is_that_of_the_environment(monkeypatch):
    assert "NUMBA_NUM_THREADS" in THREAD_VARIABLES
    monkeypatch.setenv("NUMBA_NUM_THREADS", "3")
    assert num_threads() == 3
    for nonsense in ("", "0", "many"):
        monkeypatch.setenv("NUMBA_NUM_THREADS", nonsense)
        assert num_threads() >= 1


def test_slurm_allows_fewer_processors_and_never_more(monkeypatch):
    monkeypatch.delenv("NUMBA_NUM_THREADS", raising=False)
    monkeypatch.delenv("SLURM_CPUS_PER_TASK", raising=False)
    bound = num_processors()
    monkeypatch.setenv("SLURM_CPUS_PER_TASK", "1")
    assert num_processors() == num_threads() == 1
    monkeypatch.setenv("SLURM_CPUS_PER_TASK", str(bound + 1))
    assert num_processors() == bound
