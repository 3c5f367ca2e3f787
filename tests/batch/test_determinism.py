"""The same bytes for any scheduler, number of workers and threads, hash seed and locale."""

import json
import os
import subprocess
import sys

import pytest

from tests.recordings import render_drive

JOBS = """
[[job]]
name = "wall"
command = "reconstruct"
input = "drive"
quality = "fast"
settings = { "map.partition_size" = 64 }

[[job]]
name = "walk"
command = "explore"
input = "three_kinds"
settings = { "exploration.max_pairs" = 2, "eyes.width" = 96, "eyes.height" = 96 }
"""
CALL = "import sys; from recon.cli import entry; sys.argv[0] = 'recon'; sys.exit(entry())"
WITH_TIMES = {"manifest.json", "metrics.json"}


def batch(folder, name, *given, **environment):
    """Run the batch in a separate process."""
    argv = [sys.executable, "-c", CALL, "batch", str(folder / "jobs.toml"), "-o",
            str(folder / name), "-q", *given]  # fmt: skip
    subprocess.run(argv, check=True, env=os.environ | environment, capture_output=True)


def content(run):
    """Read every file of a run except those that hold times."""
    return {
        path.relative_to(run).as_posix(): path.read_bytes()
        for path in sorted(run.rglob("*"))
        if path.is_file() and path.name not in WITH_TIMES
    }


def without_times(run):
    return json.loads((run / "metrics.json").read_text()) | {"seconds": None, "run": None}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("same")
    render_drive(folder, 3)
    (folder / "jobs.toml").write_text(JOBS)
    batch(folder, "one", "-j", "1", LANG="C.UTF-8", PYTHONHASHSEED="1")
    return folder


@pytest.mark.parametrize(
    ("given", "environment"),
    [
        (
            ["-j", "2"],
            {"LANG": "C", "LC_ALL": "C", "PYTHONHASHSEED": "2", "NUMBA_NUM_THREADS": "2"},
        ),
        pytest.param(
            ["-j", "2", "--scheduler", "local"],
            {"PYTHONHASHSEED": "3"},
            marks=pytest.mark.cluster,
        ),
    ],
    ids=["two processes, C locale, two threads", "Dask"],
)
def test_bytes_equal_those_of_one_worker(folder, given, environment):
    if "--scheduler" in given:
        pytest.importorskip("distributed")
    name = "dask" if "--scheduler" in given else "two"
    batch(folder, name, *given, **environment)
    for job in ("wall", "walk"):
        own, other = folder / "one" / job, folder / name / job
        assert content(own) == content(other)
        assert without_times(own) == without_times(other)
