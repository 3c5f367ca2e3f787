"""The summary of a batch: a table of its jobs, one confusion where truth is known, its figures."""

import csv
import io
import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from recon.batch.batch import SUMMARY, BatchReport
from recon.files import atomic_path

FIRST = ("name", "state", "error", "seconds")
"""Columns that every job has."""


def write_summary(report: BatchReport) -> dict[str, Any]:
    """Write `summary.json` and `summary.csv`; the document."""
    document = report.as_json() | {"num_failed": report.num_failed}
    _write(report.folder / SUMMARY, json.dumps(document, indent=2) + "\n")
    _write(report.folder / "summary.csv", as_csv(report))
    return document


def as_csv(report: BatchReport) -> str:
    """One row per job: its name and state, the settings it was swept over, and its numbers."""
    rows = [
        dict(job.swept) | dict(_flat(outcome.as_json()))
        for job, outcome in zip(report.jobs, report.outcomes, strict=True)
    ]
    names = [*FIRST, *dict.fromkeys(key for row in rows for key in row if key not in FIRST)]
    text = io.StringIO()
    writer = csv.DictWriter(text, names, lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()


def _flat(numbers: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """Numbers and words; what is a list or a table has no cell."""
    for key, value in numbers.items():
        if value is None or isinstance(value, (str, int, float)):
            yield key, value


def _write(path: Path, text: str) -> None:
    with atomic_path(path) as part:
        part.write_text(text, encoding="utf-8")
