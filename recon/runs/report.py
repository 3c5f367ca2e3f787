"""The report of a job, just done or read again from its run folder."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from recon.errors import InputError
from recon.files import documents
from recon.notices import Notice
from recon.records import FoundObject
from recon.records.objects import from_json

Numbers = dict[str, Any]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Report:
    """Results of a job."""

    kind: str
    """Of the job."""
    numbers: Numbers = field(repr=False)
    """Results by the names of the JSON document."""
    warnings: tuple[Notice, ...] = ()
    """Findings that contradict each other."""
    run: Path | None = None
    """The run folder it left."""

    def __getitem__(self, name: str) -> Any:
        return self.numbers[name]

    @property
    def objects(self) -> tuple[FoundObject, ...]:
        """The objects that were found; empty for kinds that find none."""
        return from_json(self.numbers) if "objects" in self.numbers else ()

    @property
    def is_interrupted(self) -> bool:
        """True where the job was interrupted and can be resumed."""
        return bool(self.numbers.get("stop_reason") == "interrupted")

    def as_json(self) -> dict[str, Any]:
        """The document that `--json` prints."""
        run = {} if self.run is None else {"run": str(self.run)}
        return run | self.numbers | {"warnings": [notice.as_json() for notice in self.warnings]}


def read_json(path: Path) -> Any:
    """A JSON file of a run folder.

    Raises
    ------
    InputError
        Where it is not there or is not JSON.
    """
    try:
        return documents.read_json(path)
    except FileNotFoundError as error:
        raise InputError(f"{path} is missing; is {path.parent} a finished run?") from error


def read_report(kind: str, run_path: Path) -> Report:
    """The report of a run, from its folder.

    Raises
    ------
    InputError
        Where a file is missing or damaged.
    """
    numbers = read_json(run_path / "metrics.json")
    if not isinstance(numbers, dict):
        raise InputError(f"{run_path} holds a damaged metrics.json")
    if (run_path / "objects.json").exists():
        objects = read_json(run_path / "objects.json")
        if not (isinstance(objects, dict) and "objects" in objects):
            raise InputError(f"{run_path} holds a damaged objects.json")
        numbers["objects"] = objects["objects"]
    warnings = tuple(Notice(**notice) for notice in numbers.pop("warnings", []))
    return Report(kind=kind, numbers=numbers, warnings=warnings, run=run_path)
