"""Summaries of a batch: contact sheet, confusion matrix, and tables and plots of a sweep."""

import csv
import json
from dataclasses import replace

import pytest

from recon.batch.batch import BatchReport
from recon.batch.jobfile import NamedJob
from recon.batch.summary import write_summary
from recon.batch.sweeps import Point
from recon.batch.worker import Outcome
from recon.errors import InputError
from recon.figures import contact
from recon.figures.canvas import pixels, save
from recon.figures.contact import Print, columns_of, thumbnail
from recon.figures.sweep import sweep
from recon.runs.job import Job

SHARE_BY_COUNT = {1: 0.5, 2: 0.7, 5: 0.9}


def make_report(folder, outcomes=None):
    """Make a report of a sweep of three values over two recordings, with one failed job."""
    jobs, found = [], []
    for count, share in SHARE_BY_COUNT.items():
        for name in ("a", "b"):
            job = Job(kind="reconstruct", inputs=(name,))
            swept = (("map.min_count", count), ("matching.matcher", "phase"))
            jobs.append(NamedJob(name=f"{name}-{count}", job=job, swept=swept))
            failed = (name, count) == ("b", 5)
            found.append(
                Outcome(
                    name=f"{name}-{count}",
                    state="failed" if failed else "done",
                    error="the disk is full" if failed else None,
                    numbers={} if failed else {"share": share + (name == "b") * 0.1, "curve": [1]},
                    names=() if failed else (("pine", "pine"), ("bush", "pine")),
                )
            )
            figures = folder / f"{name}-{count}" / "figures"
            figures.mkdir(parents=True)
            (figures / "broken.png").write_bytes(b"not a picture")
    save(sweep({"x": [(1, 1.0)]}, "a", "b"), folder / "a-1" / "figures" / "overview.png")
    return BatchReport(folder=folder, jobs=tuple(jobs), outcomes=tuple(outcomes or found))


def test_sweep_is_tabulated_and_plotted(tmp_path):
    document = write_summary(make_report(tmp_path), ["share"])
    assert document["sweep"] == [
        {"map.min_count": count, "matching.matcher": "phase", "jobs": jobs,
         "share": pytest.approx(mean)}
        for count, jobs, mean in ((1, 2, 0.55), (2, 2, 0.75), (5, 1, 0.9))
    ]  # fmt: skip
    with (tmp_path / "sweep.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert [row["map.min_count"] for row in rows] == ["1", "2", "5"]
    assert float(rows[2]["share"]) == pytest.approx(0.9)
    assert (tmp_path / "sweep_share.png").exists()


def test_confusion_matrix_counts_all_jobs_with_known_truth(tmp_path):
    document = write_summary(make_report(tmp_path), ["share"])
    assert (document["num_objects"], document["num_right"]) == (10, 5)
    assert document["confusion"] == {"bush": {"pine": 5}, "pine": {"pine": 5}}
    assert (tmp_path / "confusion.png").exists()


def test_contact_sheet_is_reproducible_and_skips_broken_images(tmp_path):
    report = make_report(tmp_path / "one")
    write_summary(report, ["share"])
    first = (tmp_path / "one" / "contact.png").read_bytes()
    write_summary(report, ["share"])
    assert (tmp_path / "one" / "contact.png").read_bytes() == first
    height, width, depth = thumbnail(tmp_path / "one/a-1/figures/overview.png").shape
    assert depth == 3
    assert 0.8 < max(width / contact.CELL[0], height / contact.CELL[1]) <= 1
    assert thumbnail(tmp_path / "one" / "b-1" / "figures" / "broken.png") is None


def test_contact_sheet_shows_images_or_the_reason_for_a_missing_one(tmp_path):
    save(sweep({"x": [(1, 1.0)]}, "a", "b"), tmp_path / "a.png")
    blank, drawn, said = (
        pixels(contact.contact([Print(name="a", image=image, note=note)]))
        for image, note in ((None, ""), (thumbnail(tmp_path / "a.png"), ""), (None, "failed"))
    )
    assert (drawn != blank).sum() > (said != blank).sum() > 50


def test_contact_sheet_is_roughly_square():
    for num in (1, 2, 7, 100, contact.MAX_SHOWN):
        width, height = (
            contact.CELL[0] * columns_of(num),
            contact.CELL[1] * -(-num // columns_of(num)),
        )
        assert 0.5 <= width / height <= 2.9
        assert max(width, height) <= 8192


def test_swept_words_are_equally_spaced_and_the_line_shows_their_means():
    figure = sweep({"all": [("fast", 1.0), ("best", 3.0), ("fast", 2.0)]}, "quality", "rms")
    (axes,) = figure.axes
    assert [label.get_text() for label in axes.get_xticklabels()] == ["fast", "best"]
    _, line = axes.lines
    assert line.get_ydata().tolist() == [1.5, 3.0]


def test_sweep_of_which_every_job_failed_is_summarised(tmp_path):
    report = make_report(tmp_path)
    failed = [Outcome(name=one.name, state="failed", error="full") for one in report.outcomes]
    document = write_summary(replace(report, outcomes=tuple(failed)))
    assert document["num_failed"] == 6
    assert [row["jobs"] for row in document["sweep"]] == [0, 0, 0]
    assert (tmp_path / "contact.png").exists()
    assert (tmp_path / "sweep_seconds.png").exists()


def test_unknown_metric_is_rejected_after_the_summary_is_written(tmp_path):
    with pytest.raises(InputError, match="known are seconds, share"):
        write_summary(make_report(tmp_path), ["shares"])
    assert len(json.loads((tmp_path / "summary.json").read_text())["jobs"]) == 6


def test_mean_of_a_metric_counts_only_the_jobs_that_have_it():
    point = Point(values={}, runs=[{"rms_px": 1.0}, {"rms_px": 2.0}, {"seconds": 9.0}])
    assert point.mean("rms_px") == 1.5
    assert point.mean("num_pairs") is None
