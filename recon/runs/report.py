"""The report of a job, just executed or read from its run folder."""

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
    """Kind of the job."""
    numbers: Numbers = field(repr=False)
    """Results by the keys of the JSON document."""
    warnings: tuple[Notice, ...] = ()
    """Contradictory findings."""
    run: Path | None = None
    """The run folder, if any."""

    def __getitem__(self, name: str) -> Any:
        return self.numbers[name]

    @property
    def objects(self) -> tuple[FoundObject, ...]:
        """The objects found; empty for kinds without objects."""
        return from_json(self.numbers) if "objects" in self.numbers else ()

    @property
    def is_interrupted(self) -> bool:
        """True if the job was interrupted and can be resumed."""
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
        If it is missing or not JSON.
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
        If a file is missing or damaged.
    """
    numbers = read_json(run_path / "metrics.json")
    if not isinstance(numbers, dict):
        raise InputError(f"{run_path} has a damaged metrics.json")
    if (run_path / "objects.json").exists():
        objects = read_json(run_path / "objects.json")
        if not (isinstance(objects, dict) and "objects" in objects):
            raise InputError(f"{run_path} has a damaged objects.json")
        numbers["objects"] = objects["objects"]
    warnings = tuple(Notice(**notice) for notice in numbers.pop("warnings", []))
    return Report(kind=kind, numbers=numbers, warnings=warnings, run=run_path)
