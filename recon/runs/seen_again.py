"""The pairs of a finished run, at the poses of the run."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from recon.errors import InputError
from recon.geometry import Array
from recon.manifest import input_paths, read_manifest
from recon.records import StereoPair, Trajectory, View
from recon.sequences.open import open_sequence
from recon.settings import Settings, updated
from recon.world.library import find_scene
from recon.world.world import World

RECORDED, SIMULATED = "reconstruct", "explore"
"""Commands whose runs have poses and reproducible images."""
_SOURCES = {RECORDED: "recording", SIMULATED: "scene"}


class SeenAgain:
    """A run's recording read again, or its simulated world rendered again.

    Parameters
    ----------
    run : Path
    settings : Settings
        The run's settings, possibly modified.
    source : Path, optional
        Current path of the recording or scene; by default as in the run's manifest.

    Raises
    ------
    InputError
        If the run is of another command, or its source no longer exists.
    """

    def __init__(self, run: Path, settings: Settings, source: Path | None = None) -> None:
        self.run = run
        self.settings = settings
        self.command = _command(run)
        self.source = _source(run) if source is None else source
        path = run / "trajectory.txt"
        self.poses = Trajectory.from_tum(path.read_text("utf-8"), str(path)).T_world_left

    def __len__(self) -> int:
        return len(self.poses)

    def __iter__(self) -> Iterator[StereoPair]:
        return self._read() if self.command == RECORDED else self._taken()

    def _read(self) -> Iterator[StereoPair]:
        # The run's poses are used, regardless of their origin.
        given = updated(self.settings, {"sequence": {"poses": "given"}}).sequence
        for number, pair in enumerate(open_sequence(self.source, given)):
            if number >= len(self.poses):
                raise InputError(
                    f"{self.run} has {len(self.poses)} poses, but its recording has more pairs"
                )
            yield replace(pair, T_world_left=self.poses[number])

    def _taken(self) -> Iterator[StereoPair]:
        world = World.from_file(find_scene(self.source), self.settings)
        for pose in self.poses:
            yield world.take(self._view(pose))

    def _view(self, T_world_left: Array) -> View:
        """The view from a pose; the cameras fixate at the viewing distance."""
        right, ahead = T_world_left[:3, 0], T_world_left[:3, 2]
        position = T_world_left[:3, 3] + 0.5 * self.settings.eyes.baseline * right
        return View(
            position=position, target=position + self.settings.exploration.clearance * ahead
        )


def _command(run: Path) -> str:
    command: str = read_manifest(run)["command"]
    if command not in (RECORDED, SIMULATED):
        raise InputError(
            f"{run} is a run of {command}, but one of {RECORDED} or {SIMULATED} is needed"
        )
    return command


def _source(run: Path) -> Path:
    paths = input_paths(read_manifest(run))
    path = paths[0] if paths else Path()
    if not (paths and path.exists()):
        named = _SOURCES[_command(run)]
        raise InputError(f"the {named} of {run} is not at {str(path)!r}: give --recording PATH")
    return path
