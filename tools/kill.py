"""Kill commands at random moments, resume and compare: python tools/kill.py [-n N] [--seed S].

Each trial runs explore, reconstruct or batch on a small input, kills it with SIGKILL once or more,
and finishes it with `--resume`. Every file must equal that of an undisturbed run, except for the
times in it. A failing trial is named by its seed, and its folder is kept in `kills/`.
"""

import argparse
import json
import os
import shutil
import signal
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))

from recon.cli import main as recon
from recon.libraries import limit_threads
from tests.recordings import render_drive

JOBS = """
[[job]]
name = "wall"
command = "reconstruct"
input = "drive"
quality = "fast"
arguments = { chunk = 2 }

[[job]]
name = "walk"
command = "explore"
input = "three_kinds"
settings = { "exploration.max_pairs" = 3, "eyes.width" = 96, "eyes.height" = 96 }
"""
SMALL = ["--set", "eyes.width=96", "--set", "eyes.height=96", "--max-pairs", "3"]
TIMES = {"manifest.json", "summary.csv"}
"""Files that hold times; of those named below, the times are left out."""
TIMED = {"metrics.json", "summary.json"}
MAX_KILLS = 3
SLOWEST_S = 300


def commands(folder: Path) -> dict[str, list[str]]:
    """List the arguments of each command except for the run folder."""
    drive = render_drive(folder, 4)
    (folder / "jobs.toml").write_text(JOBS)
    return {
        "explore": ["explore", "three_kinds", "-q", *SMALL],
        "reconstruct": ["reconstruct", str(drive), "-q", "--quality", "fast", "--chunk", "2"],
        "batch": ["batch", str(folder / "jobs.toml"), "-q", "-j", "2"],
    }


def run(argv: list[str], kill_after_s: float | None = None) -> int | None:
    """Run a command in its own process group; return its exit code, or None if killed."""
    child = os.fork()
    if child == 0:
        os.setsid()
        os._exit(recon(argv))
    end = time.monotonic() + (SLOWEST_S if kill_after_s is None else kill_after_s)
    while time.monotonic() < end:
        done, status = os.waitpid(child, os.WNOHANG)
        if done:
            return os.waitstatus_to_exitcode(status)
        time.sleep(0.002)
    os.killpg(child, signal.SIGKILL)
    os.waitpid(child, 0)
    return None


def content(run: Path) -> dict[str, Any]:
    """Read every file of a run, without times."""
    found: dict[str, Any] = {}
    for path in sorted(run.rglob("*")):
        name = path.relative_to(run).as_posix()
        if path.name in TIMED:
            found[name] = untimed(json.loads(path.read_text()))
        elif path.is_file() and path.name not in TIMES:
            found[name] = path.read_bytes()
    return found


def untimed(document: Any) -> Any:
    """Remove durations, and the outcome of a job's first attempt, from a document."""
    if isinstance(document, list):
        return [untimed(one) for one in document]
    if not isinstance(document, dict):
        return document
    return {n: untimed(v) for n, v in document.items() if n not in ("seconds", "run", "state")}


def trial(argv: list[str], whole: Path, seconds: float, rng: np.random.Generator) -> str | None:
    """Kill and resume a command; return the fault found, or None."""
    target = whole.with_name("cut")
    shutil.rmtree(target, ignore_errors=True)
    call = [*argv, "-o", str(target), "--resume"]
    for _ in range(rng.integers(1, MAX_KILLS + 1)):
        run(call, float(rng.uniform(0.0, seconds)))
    code = run(call)
    if code != 0:
        return f"resumed, it ends with {code}"
    expected, found = content(whole), content(target)
    names = [n for n in expected.keys() | found.keys() if expected.get(n) != found.get(n)]
    strays = [p.name for p in whole.parent.glob(".*") if not p.name.endswith(".lock")]
    return f"{sorted(names)} differ, {strays} are left" if names or strays else None


def main() -> int:
    """Run the trials, print one line per command, and return 1 if anything failed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-n", type=int, default=50, help="trials in all")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--command", choices=["explore", "reconstruct", "batch"])
    given = parser.parse_args()
    limit_threads(1)
    num_failed = 0
    with tempfile.TemporaryDirectory() as folder:
        known = commands(Path(folder))
        if given.command is not None:
            known = {given.command: known[given.command]}
        for position, (name, argv) in enumerate(known.items()):
            numbers = range(position, given.n, len(known))
            num_failed += _of_command(name, argv, Path(folder) / name, numbers, given.seed)
    return int(num_failed > 0)


def _of_command(name: str, argv: list[str], home: Path, numbers: range, seed: int) -> int:
    home.mkdir()
    whole = home / "whole"
    # Once in this process, so that kernels are cached for every child.
    assert recon([*argv, "-o", str(whole)]) == 0
    began = time.monotonic()
    assert run([*argv, "-o", str(whole), "--overwrite"]) == 0
    seconds = time.monotonic() - began
    num_failed = 0
    for number in numbers:
        wrong = trial(argv, whole, seconds, np.random.default_rng([seed, number]))
        if wrong:
            num_failed += 1
            print(f"{name}, trial {number}: {wrong}", flush=True)
            shutil.copytree(home, Path("kills") / f"{seed}-{number}", dirs_exist_ok=True)
    print(f"{name:12} {len(numbers) - num_failed} of {len(numbers)} equal", flush=True)
    return num_failed


if __name__ == "__main__":
    sys.exit(main())
