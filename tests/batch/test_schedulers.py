"""A Dask scheduler that disappears: finished jobs stay, the others fail with one line each."""

import subprocess
import sys
import time
from functools import partial
from pathlib import Path

import pytest

from recon.batch.schedulers import Dask
from recon.batch.worker import Outcome

pytestmark = pytest.mark.cluster

CLUSTER = """
from distributed import LocalCluster
cluster = LocalCluster(protocol="tcp://", n_workers=1, threads_per_worker=1, processes=False,
                       dashboard_address=None)
print(cluster.scheduler_address, flush=True)
input()
"""


def finish_after(seconds, name):
    time.sleep(seconds)
    return Outcome(name=name, state="done")


def test_lost_scheduler_fails_only_unfinished_jobs():
    pytest.importorskip("distributed")
    root = Path(__file__).parents[2]
    with subprocess.Popen(
        [sys.executable, "-c", CLUSTER], cwd=root, stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as cluster:
        address = cluster.stdout.readline().decode().strip()
        calls = [
            ("quick", partial(finish_after, 0, "quick")),
            ("slow", partial(finish_after, 600, "slow")),
        ]
        found = {}
        for outcome in Dask(address, 1).outcomes(calls):
            found[outcome.name] = outcome
            cluster.kill()
    assert found["quick"].state == "done"
    assert found["slow"].state == "failed"
    assert found["slow"].error == f"the connection to the scheduler at {address} was lost"
