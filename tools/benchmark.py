"""Measure recon, topic by topic, against named peers in the same run.

    python tools/benchmark.py                       everything
    python tools/benchmark.py stereo --quick        one topic, few runs
    python tools/benchmark.py --gate                exit 1 if a number is worse than the baseline
    python tools/benchmark.py --update-baseline

Timings are ratios to a peer in the same run, so that they are comparable across machines.
"""

import importlib
import json
import os
from pathlib import Path

import click
from benchmarks import Measurement

TOOLS = Path(__file__).parent
BASELINE = TOOLS / "benchmark.json"
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS")
TOPICS = sorted(path.stem for path in (TOOLS / "benchmarks").glob("[!_]*.py"))


@click.command()
@click.argument("topics", nargs=-1, type=click.Choice(TOPICS))
@click.option("--quick", is_flag=True, help="Few runs; not comparable with the baseline.")
@click.option("--gate", is_flag=True, help="Fail where a number is behind the baseline.")
@click.option("--update-baseline", is_flag=True)
def main(topics: tuple[str, ...], quick: bool, gate: bool, update_baseline: bool) -> None:
    """Print every number with its unit and its baseline."""
    if quick and (gate or update_baseline):
        raise click.UsageError("--quick is not comparable with the baseline")
    # Before any numerical library is loaded: everything is measured on one thread.
    os.environ.update(dict.fromkeys(THREADS, "1"))
    baseline = json.loads(BASELINE.read_text()) if BASELINE.exists() else {}
    found = [number for topic in topics or TOPICS for number in measure(topic, quick)]
    late = [number.name for number in found if is_behind(number, baseline.get(number.name))]
    for number in found:
        print_row(number, baseline.get(number.name))
    if update_baseline:
        values = baseline | {number.name: round(number.value, 4) for number in found}
        BASELINE.write_text(json.dumps(values, indent=2, sort_keys=True) + "\n")
    elif gate and late:
        raise click.ClickException(f"behind the baseline: {', '.join(late)}")


def measure(topic: str, quick: bool) -> list[Measurement]:
    """Run the measurements of one topic."""
    return importlib.import_module(f"benchmarks.{topic}").measure(quick)


def is_behind(number: Measurement, baseline: float | None) -> bool:
    """True if a number is worse than its baseline by more than its tolerance."""
    if baseline is None:
        return False
    slack = number.tolerance * abs(baseline)
    if number.better == "lower":
        return number.value > baseline + slack
    return number.value < baseline - slack


def print_row(number: Measurement, baseline: float | None) -> None:
    """Print one line: name, value, unit, baseline."""
    before = "" if baseline is None else f"(baseline {baseline:g})"
    print(f"{number.name:44} {number.value:12.4g} {number.unit:28} {before}")


if __name__ == "__main__":
    main()
