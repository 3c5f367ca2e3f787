"""What a caller says of a run besides its input and its settings."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from recon.runfolder import RunFolder, RunPlan
from recon.settings import Settings, to_toml

Progress = Callable[[int, int], None]
"""Called with the pairs done and the most there can be."""


def unwatched(done: int, total: int) -> None:
    """No progress is shown."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RunOrder:
    """Where a run goes, and how."""

    path: Path
    seed: int = 0
    overwrite: bool = False
    resume: bool = False
    progress: Progress = unwatched

    def folder(self, command: str, settings: Settings, inputs: tuple[Path, ...]) -> RunFolder:
        """The run folder, refused where it holds another run."""
        plan = RunPlan(
            command=command, settings_toml=to_toml(settings), seed=self.seed, inputs=inputs
        )
        return RunFolder.prepare(self.path, plan, overwrite=self.overwrite, resume=self.resume)
