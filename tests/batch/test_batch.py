"""Batches finish whatever happens to a job, resume, and write what single runs write."""

import csv
import json
import os
import pickle
import shutil
import signal
import subprocess
import sys
import time
from contextvars import Context
from pathlib import Path

import pytest

from recon.batch.batch import run_batch
from recon.batch.jobfile import read_jobs
from recon.batch.schedulers import MAX_TRIES, Processes, bound, lost, make_scheduler
from recon.batch.summary import as_csv
from recon.batch.worker import Outcome, do, report_progress_to
from recon.cli import main
from recon.errors import InputError
from recon.files import check_memory, may_read, memory_limit, outside_allowed
from recon.manifest import read_manifest
from recon.runs.events import Cancelled

JOBS = """
[[job]]
name = "walk"
command = "explore"
input = "three_kinds"
settings = { "exploration.max_pairs" = 2, "eyes.width" = 96, "eyes.height" = 96 }

[[job]]
name = "nowhere"
command = "reconstruct"
input = "nowhere"
"""


class InProcess:
    """A scheduler that runs every call immediately, in this process."""

    def outcomes(self, calls):
        for _, call in calls:
            yield call()


@pytest.fixture(scope="module")
def batch(tmp_path_factory):
    folder = tmp_path_factory.mktemp("batch")
    (folder / "jobs.toml").write_text(JOBS)
    code = main(["batch", str(folder / "jobs.toml"), "-o", str(folder / "out"), "-j", "1", "-q"])
    for ending in ("json", "csv"):  # other tests resume the batch
        shutil.copyfile(folder / f"out/summary.{ending}", folder / f"first.{ending}")
    return folder, code


def test_failed_job_is_reported_and_stops_no_other(batch):
    folder, code = batch
    assert code == 5
    jobs = json.loads((folder / "first.json").read_text())["jobs"]
    assert [(one["name"], one["state"]) for one in jobs] == [
        ("walk", "done"),
        ("nowhere", "failed"),
    ]
    assert jobs[0]["num_pairs"] == 2
    assert (folder / "out" / "contact.png").exists()
    assert json.loads((folder / "first.json").read_text())["num_objects"] == 3
    assert "nowhere" in jobs[1]["error"]
    with (folder / "first.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert [row["state"] for row in rows] == ["done", "failed"]
    assert rows[0]["num_pairs"] == "2"


def test_job_writes_the_same_bytes_as_a_single_run(batch, tmp_path, without_figures):
    folder, _ = batch
    alone = tmp_path / "alone"
    given = [
        "--set",
        "exploration.max_pairs=2",
        "--set",
        "eyes.width=96",
        "--set",
        "eyes.height=96",
    ]
    assert main(["explore", "three_kinds", "-o", str(alone), "-q", *given]) == 0
    for name in ("map.npz", "cloud.ply", "objects.json", "trajectory.txt", "settings.toml"):
        assert (folder / "out" / "walk" / name).read_bytes() == (alone / name).read_bytes(), name


def test_resume_skips_finished_jobs_and_retries_failed_ones(batch, capsys):
    folder, _ = batch
    before = (folder / "out" / "walk" / "map.npz").stat().st_mtime_ns
    given = ["batch", str(folder / "jobs.toml"), "-o", str(folder / "out"), "-j", "1", "--json"]
    assert main([*given, "--resume"]) == 5
    jobs = json.loads(capsys.readouterr().out)["jobs"]
    assert [one["state"] for one in jobs] == ["skipped", "failed"]
    assert (folder / "out" / "walk" / "map.npz").stat().st_mtime_ns == before
    assert main(given) == 2  # neither --resume nor --overwrite


def test_dry_run_lists_jobs_without_running_them(batch, tmp_path, capsys):
    folder, _ = batch
    given = ["batch", str(folder / "jobs.toml"), "-o", str(tmp_path / "out"), "--dry-run", "--json"]
    assert main(given) == 0
    assert [one["name"] for one in json.loads(capsys.readouterr().out)["jobs"]] == [
        "walk",
        "nowhere",
    ]
    assert not (tmp_path / "out").exists()


def test_folder_that_is_not_a_batch_is_not_overwritten(tmp_path):
    (tmp_path / "thesis.txt").write_text("years of work")
    with pytest.raises(InputError, match="is not the folder of a batch"):
        run_batch([], tmp_path, InProcess(), overwrite=True)
    assert (tmp_path / "thesis.txt").exists()


def test_word_that_is_no_address_of_a_scheduler_is_rejected_at_once():
    with pytest.raises(InputError, match="scheduler is 'foo', but local or tcp://HOST:PORT"):
        make_scheduler("foo", 1)


def test_unexpected_exception_becomes_a_failed_outcome(tmp_path, monkeypatch):
    def broken(*_):
        raise ZeroDivisionError("division\nby zero")

    monkeypatch.setattr("recon.batch.worker._execute", broken)
    (tmp_path / "jobs.toml").write_text(JOBS)
    outcome = do(read_jobs(tmp_path / "jobs.toml")[0], tmp_path / "run")
    assert (outcome.state, outcome.error) == ("failed", "ZeroDivisionError: division by zero")


def die_once(mark):
    """Kill the worker the first time."""
    if not mark.exists():
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return Outcome(name="a", state="done")


def test_job_of_a_lost_worker_continues_its_run(batch, without_figures):
    folder, _ = batch
    job = read_jobs(folder / "jobs.toml")[0]
    assert do(job, folder / "out" / "walk").state == "skipped"
    manifest = folder / "out" / "walk" / "manifest.json"
    whole = manifest.read_text()
    manifest.write_text(whole.replace('"finished"', '"running"'))
    again = do(job, folder / "out" / "walk")
    assert (again.state, again.error) == ("done", None)


def test_job_whose_batch_was_interrupted_before_does_not_begin(batch, tmp_path):
    def tell(*_):
        raise Cancelled

    report_progress_to(tell)
    try:
        with pytest.raises(Cancelled):
            do(read_jobs(batch[0] / "jobs.toml")[0], tmp_path / "run")
    finally:
        report_progress_to(None)
    assert not (tmp_path / "run").exists()


def die():
    os.kill(os.getpid(), signal.SIGKILL)


def test_lost_worker_is_replaced_and_its_job_retried(tmp_path):
    from functools import partial

    calls = [("a", partial(die_once, tmp_path / "mark"))]
    assert [one.state for one in Processes(1).outcomes(calls)] == ["done"]


ORPHAN_SCRIPT = """
import sys
from recon.batch.schedulers import Processes
from recon.processes import SPAWN, start_server
from tests.batch.test_batch import wait_forever
if __name__ == "__main__":
    start = start_server("recon.batch.loaded") if sys.argv[1] == "forked" else SPAWN
    for _ in Processes(1, start=start).outcomes([("a", wait_forever)]): pass
"""


def wait_forever():
    os.write(1, b"%d\n" % os.getpid())
    time.sleep(600)


@pytest.mark.parametrize("way", ["forked", "spawned"])
def test_worker_does_not_outlive_the_batch(tmp_path, way):
    (tmp_path / "lonely.py").write_text(ORPHAN_SCRIPT)
    here = {"PYTHONPATH": os.pathsep.join([str(Path(__file__).parents[2]), *sys.path])}
    with subprocess.Popen(
        [sys.executable, tmp_path / "lonely.py", way],
        stdout=subprocess.PIPE,
        env=os.environ | here,
    ) as parent:
        assert int(parent.stdout.readline()) != parent.pid
        parent.kill()
        # The pipe closes when the last process that holds it has ended.
        assert parent.stdout.read() == b""


WALK = '[[job]]\nname = "walk"\ncommand = "explore"\ninput = "village"\n'
SLOWEST_S = 600
"""Time for kernels to compile on a slow machine, before and after the signal."""


def test_batch_that_is_told_to_end_interrupts_its_jobs(tmp_path):
    (tmp_path / "jobs.toml").write_text(WALK)
    out = tmp_path / "out"
    script = "from recon.cli.main import entry; entry()"
    argv = ["batch", str(tmp_path / "jobs.toml"), "-j", "1", "-q", "-o", str(out)]
    with subprocess.Popen(
        [sys.executable, "-c", script, *argv], cwd=Path(__file__).parents[2]
    ) as process:
        try:
            give_up = time.monotonic() + SLOWEST_S
            while not list(out.glob("walk/partial/*")) and time.monotonic() < give_up:
                time.sleep(0.02)
            process.send_signal(signal.SIGTERM)
            assert process.wait(SLOWEST_S) == 130
        finally:
            process.kill()
    assert read_manifest(out / "walk")["state"] == "interrupted"


def report_progress(name, num):
    from recon.batch.worker import _listener

    for done in range(num):
        _listener[-1](name, done + 1, num)
    return Outcome(name=name, state="done")


def test_progress_of_every_job_is_reported_in_order():
    from functools import partial

    heard = []
    calls = [(name, partial(report_progress, name, 3)) for name in "ab"]
    scheduler = Processes(2, progress=lambda *said: heard.append(said))
    for _ in range(2):
        heard.clear()
        assert sorted(one.name for one in scheduler.outcomes(calls)) == ["a", "b"]
    for name in "ab":
        assert [said for said in heard if said[0] == name] == [(name, n, 3) for n in (1, 2, 3)]


def test_job_that_kills_every_worker_fails_with_one_line():
    outcome = lost("a")
    assert outcome.state == "failed"
    assert f"died {MAX_TRIES} times" in outcome.error
    assert "\n" not in outcome.error


def test_swept_setting_is_a_column(tmp_path):
    text = JOBS.split('[[job]]\nname = "nowhere"')[0] + "[sweep]\nmap.min_count = [1, 2]\n"
    (tmp_path / "jobs.toml").write_text(text)
    jobs = read_jobs(tmp_path / "jobs.toml")

    class Skipped:
        def outcomes(self, calls):
            yield from (Outcome(name=name, state="skipped") for name, _ in reversed(calls))

    report = run_batch(jobs, tmp_path / "out", Skipped())
    rows = list(csv.DictReader(as_csv(report).splitlines()))
    assert [row["map.min_count"] for row in rows] == ["1", "2"]


def limits_in_worker():
    """Read the limits that apply in a worker."""
    try:
        check_memory("a file", 2000)
    except InputError:
        return may_read("/elsewhere", Path("/here")), "refused"
    return may_read("/elsewhere", Path("/here")), "allowed"


def test_limits_of_the_batch_apply_in_its_workers():
    with outside_allowed(), memory_limit(1000):
        call = bound(limits_in_worker)
    usual = bound(limits_in_worker)
    # A worker starts with a new context.
    assert Context().run(pickle.loads(pickle.dumps(call))) == (True, "refused")
    assert Context().run(usual) == (False, "allowed")
