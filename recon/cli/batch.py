"""`recon batch`."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from recon.cli.info import table
from recon.cli.options import OUTPUT, PATH, SCENE, NamedPath, with_options
from recon.cli.output import print_document, start_logging
from recon.cli.progress import shown_jobs

if TYPE_CHECKING:
    from multiprocessing.context import BaseContext

    from recon.batch.jobfile import NamedJob
    from recon.batch.worker import Outcome
    from recon.figures.contact import Print

SOME_FAILED = 5


@click.command(epilog="Example: recon batch jobs.toml -j 4 -o runs/all --resume")
@click.argument("jobs", metavar="JOBS.toml|GLOB", type=NamedPath())
@click.option("--command", help="Command to run on each match of a glob: reconstruct, explore, ...")
@click.option(
    "-j",
    "num_workers",
    type=click.IntRange(min=1),
    help="Number of workers, one per processor by default.",
)
@click.option(
    "--scheduler", metavar="local|tcp://HOST:PORT", help="Run the jobs on a Dask cluster."
)
@click.option(
    "--chunk",
    type=click.IntRange(min=1),
    metavar="N",
    help="Split recordings into jobs of N pairs and merge them into one map, the run `merged`.",
)
@click.option(
    "--metric",
    "metrics",
    multiple=True,
    metavar="NAME",
    help="Column of summary.csv to tabulate and plot over a sweep; repeatable.",
)
@click.option("-o", "--output", type=PATH, help="Folder of the batch, runs/NAME by default.")
@click.option("--overwrite", is_flag=True, help="Replace an existing batch.")
@click.option("--resume", is_flag=True, help="Skip finished jobs, retry failed ones.")
@click.option("--dry-run", is_flag=True, help="List the jobs without running them.")
@with_options(SCENE, OUTPUT)
def batch(jobs: str, **given: Any) -> int:
    """Run many jobs, each into its own run folder.

    A failed job never stops the others. JOBS.toml holds a [[job]] table per job: name, command,
    input (a path, a glob or a list), settings, seed; a [sweep] table lists values of settings.
    """
    start_logging(given)
    start = _way_to_start(given)  # first: it loads while this process does
    named = _named_jobs(jobs, given["command"])
    _check(named, given)
    if given["dry_run"]:
        _list(named, given)
        return 0
    folder = _folder(jobs, given)
    document = _run(named, folder, given, start)
    print_document(given, document, _lines(document, folder))
    return SOME_FAILED if document["num_failed"] else 0


def _run(
    named: "list[NamedJob]", folder: Path, given: dict[str, Any], start: "BaseContext"
) -> dict[str, Any]:
    """Run all jobs and write the summary, whose document is returned."""
    from recon.batch.batch import run_batch
    from recon.batch.schedulers import make_scheduler
    from recon.batch.sheets import load_ahead, print_of
    from recon.batch.summary import write_summary
    from recon.batch.sweeps import USUAL
    from recon.figures.contact import MAX_SHOWN
    from recon.threads import num_processors

    load_ahead()
    prints: dict[str, Print] = {}
    with shown_jobs(given["quiet"]) as shown:
        scheduler = make_scheduler(
            given["scheduler"], given["num_workers"] or num_processors(), shown.progress, start
        )

        def heard(outcome: "Outcome", done: int, total: int) -> None:
            shown.end(outcome.name, done, total)
            if len(prints) < MAX_SHOWN:
                prints[outcome.name] = print_of(outcome, folder)  # while other jobs run
            if outcome.state == "failed":
                click.echo(f"recon: {outcome.name}: {outcome.error}", err=True)

        report = run_batch(
            named, folder, scheduler,
            overwrite=given["overwrite"], resume=given["resume"], chunk=given["chunk"],
            heard=heard,
        )  # fmt: skip
    return write_summary(report, given["metrics"] or USUAL, prints)


def _way_to_start(given: dict[str, Any]) -> "BaseContext":
    """The way to start workers: forked from a server if this process serves the batch only."""
    from recon.processes import SPAWN, start_server

    is_alone = click.get_current_context().find_root().obj
    if not is_alone or given["dry_run"] or given["scheduler"] not in (None, "local"):
        return SPAWN
    libraries = () if given["scheduler"] is None else ("distributed",)
    return start_server("recon.batch.loaded", *libraries)


def _named_jobs(jobs: str, command: str | None) -> "list[NamedJob]":
    from recon.batch.jobfile import jobs_of_glob, read_jobs

    if command is not None:
        return jobs_of_glob(jobs, command)
    if not jobs.endswith(".toml"):
        raise click.UsageError(f"{jobs} is not a JOBS.toml; give --command with a glob")
    return read_jobs(Path(jobs))


def _check(named: "Sequence[NamedJob]", given: dict[str, Any]) -> None:
    """Refuse options that do not suit the jobs, which a dry run finds as well."""
    from recon.batch.chunks import check_chunks

    if given["metrics"] and not any(one.swept for one in named):
        raise click.UsageError("--metric is for a sweep, but no setting is swept")
    if given["chunk"] is not None:
        check_chunks(named)


def _folder(jobs: str, given: dict[str, Any]) -> Path:
    """The folder of the batch, which must not replace the file of its jobs."""
    from recon.runfolder import check_none_inside, named

    folder = named(given["output"] or Path("runs") / (Path(jobs.rstrip("/*")).stem or "batch"))
    if given["overwrite"]:
        check_none_inside(folder, [Path(jobs)])
    return folder


def _list(named: "Sequence[NamedJob]", given: dict[str, Any]) -> None:
    rows = [
        {"name": one.name, "command": one.job.kind, "input": [str(p) for p in one.job.inputs]}
        for one in named
    ]
    lines = (f"{row['name']:24} {row['command']:12} {' '.join(row['input'])}" for row in rows)
    print_document(given, {"jobs": rows}, lines)


def _lines(document: dict[str, Any], folder: Path) -> Iterator[object]:
    for row in document["jobs"]:
        yield f"{row['name']:24} {row['state']:8} {row['seconds']:8.1f} s"
    if "sweep" in document:
        yield from table(document["sweep"])
    if "num_right" in document:
        yield f"{document['num_right']} of {document['num_objects']} objects named correctly"
    yield f"{len(document['jobs']) - document['num_failed']} of {len(document['jobs'])} done"
    yield folder
