"""The results of a sweep: the mean of every metric per point, as a table and as figures."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from recon.batch.batch import BatchReport
from recon.errors import InputError

USUAL = ("seconds",)
"""Metrics shown by default."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Point:
    """One combination of the values of a sweep."""

    values: Mapping[str, Any]
    """Values by the name of the setting."""
    runs: Sequence[Mapping[str, float]]
    """The metrics of every job with these values."""

    def mean(self, metric: str) -> float | None:
        """Mean of a metric over the jobs that have it; None if none has."""
        found = [run[metric] for run in self.runs if metric in run]
        return sum(found) / len(found) if found else None


def points_of(report: BatchReport) -> list[Point]:
    """The points of the sweep of a batch; none if nothing was swept."""
    runs: dict[tuple[tuple[str, Any], ...], list[dict[str, float]]] = {}
    for job, outcome in zip(report.jobs, report.outcomes, strict=True):
        if job.swept:
            found = runs.setdefault(job.swept, [])
            if outcome.state != "failed":
                found.append(numbers_of(outcome.as_json()))
    return [Point(values=dict(swept), runs=found) for swept, found in runs.items()]


def numbers_of(row: Mapping[str, Any]) -> dict[str, float]:
    """The numeric metrics of a job, without words, lists and unknown values."""
    return {
        name: float(value)
        for name, value in row.items()
        if isinstance(value, int | float) and not isinstance(value, bool)
    }


def metrics_of(points: Sequence[Point]) -> list[str]:
    """Names of the metrics that any job has, in order."""
    return list(dict.fromkeys(name for point in points for run in point.runs for name in run))


def check_metrics(points: Sequence[Point], metrics: Sequence[str]) -> None:
    """Raise `InputError` for a metric that no job has."""
    known = metrics_of(points)
    for metric in metrics:
        if known and metric not in known:
            raise InputError(f"metric {metric!r} is unknown; known are {', '.join(known)}")


def table(points: Sequence[Point], metrics: Sequence[str]) -> list[dict[str, Any]]:
    """One row per point: its settings, the number of its jobs, and means."""
    return [
        dict(point.values) | {"jobs": len(point.runs)} | {m: point.mean(m) for m in metrics}
        for point in points
    ]


def curves(points: Sequence[Point], metric: str) -> tuple[str, dict[str, list[tuple[Any, float]]]]:
    """The first swept setting, and its value and the metric of every job, by the other settings."""
    setting = next(iter(points[0].values))
    found: dict[str, list[tuple[Any, float]]] = {}
    for point in points:
        others = [f"{k.rpartition('.')[2]} {v}" for k, v in point.values.items() if k != setting]
        rows = found.setdefault(", ".join(others) or "all jobs", [])
        rows += [(point.values[setting], run[metric]) for run in point.runs if metric in run]
    return setting, {name: rows for name, rows in found.items() if rows}
