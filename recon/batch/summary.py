"""The summary of a batch: a table of its jobs, a confusion matrix if truth is known, figures."""

import csv
import io
import json
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from recon.batch.batch import BatchReport
from recon.batch.folder import SUMMARY
from recon.batch.sheets import print_of, write_sheets
from recon.batch.sweeps import USUAL, check_metrics, metrics_of, points_of, table
from recon.figures.contact import MAX_SHOWN, Print
from recon.files import atomic_path

FIRST = ("name", "state", "error", "seconds")
"""Columns that every job has."""


def write_summary(
    report: BatchReport,
    metrics: Sequence[str] = USUAL,
    prints: Mapping[str, Print] | None = None,
) -> dict[str, Any]:
    """Write the files of a batch besides its runs.

    `summary.json` and `summary.csv`, a contact sheet of the figures, one confusion matrix over all
    jobs with known truth; for a sweep `sweep.csv`, and a figure per metric.

    Parameters
    ----------
    report : BatchReport
    metrics : sequence of str
        Tabulated and plotted over a sweep.
    prints : mapping of str to Print, optional
        Entries of the contact sheet by job name, if made as the jobs ended.

    Returns
    -------
    dict
        The document of `summary.json`.

    Raises
    ------
    InputError
        For a metric that no job has.
    """
    points = points_of(report)
    document = report.as_json() | {"num_failed": report.num_failed} | _confusion(report)
    if points:
        document["sweep"] = table(points, metrics)
        _write(report.folder / "sweep.csv", _csv(table(points, metrics_of(points))))
    _write(report.folder / SUMMARY, json.dumps(document, indent=2) + "\n")
    _write(report.folder / "summary.csv", as_csv(report))
    # Checked last, so that the results are on disk in any case.
    check_metrics(points, metrics)
    made = prints or {}
    shown = [
        made.get(one.name) or print_of(one, report.folder) for one in report.outcomes[:MAX_SHOWN]
    ]
    write_sheets(report, points, metrics, shown)
    return document


def _confusion(report: BatchReport) -> dict[str, Any]:
    """Counts of assigned names by true name over all jobs; empty without known truth."""
    named = [name for one in report.outcomes for name in one.names]
    if not named:
        return {}
    counts: dict[str, Counter[str]] = {}
    for true, found in sorted(named):
        counts.setdefault(true, Counter())[found] += 1
    return {
        "num_objects": len(named),
        "num_right": sum(true == found for true, found in named),
        "confusion": {true: dict(row) for true, row in counts.items()},
    }


def as_csv(report: BatchReport) -> str:
    """One row per job: its name and state, its swept settings, and its metrics."""
    rows = [
        dict(job.swept) | dict(_flat(outcome.as_json()))
        for job, outcome in zip(report.jobs, report.outcomes, strict=True)
    ]
    names = dict.fromkeys(key for row in rows for key in row if key not in FIRST)
    return _csv(rows, [*FIRST, *names])


def _csv(rows: Sequence[Mapping[str, Any]], names: Sequence[str] | None = None) -> str:
    names = list(dict.fromkeys(key for row in rows for key in row)) if names is None else names
    text = io.StringIO()
    writer = csv.DictWriter(text, names, lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()


def _flat(numbers: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """Numbers and words; lists and tables are omitted."""
    for key, value in numbers.items():
        if value is None or isinstance(value, (str, int, float)):
            yield key, value


def _write(path: Path, text: str) -> None:
    with atomic_path(path) as part:
        part.write_text(text, encoding="utf-8")
