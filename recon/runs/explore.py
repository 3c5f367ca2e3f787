"""An exploration, from a scene file to a run folder."""

import time
from pathlib import Path
from typing import Any

from recon.exploration.agent import Exploration, Step, explore
from recon.exports.ply import CloudWriter
from recon.records import StereoPair, View
from recon.runfolder import RunFolder
from recon.runs.contents import RunContents, Trajectory
from recon.runs.figures import leave_figures
from recon.runs.order import Progress, RunOrder
from recon.runs.products import with_views, write_metrics, write_products
from recon.runs.replay import SavedPairs
from recon.runs.report import read_report
from recon.settings import Quality, Settings
from recon.voxelmap.occupancy import occupied
from recon.world.textures import scene_files
from recon.world.world import World

# What a world asks for where nobody says otherwise. With both eyes on the target, disparities lie
# round zero (thesis, table of parameters). Pairs are matched fast, but each is checked against its
# whole row: a phantom before the eyes walls the agent in.
BASE_QUALITY: Quality = "fast"
BASE = {
    "matching.min_disparity": -10,
    "matching.max_disparity": 20,
    "matching.cross_check": "exact",
}


def explore_run(scene: Path, settings: Settings, order: RunOrder) -> dict[str, Any]:
    """Explore a world and leave its run folder.

    Returns
    -------
    dict
        The document of `recon explore --json`: metrics.json with `run` and `objects`.
    """
    world = World.from_file(scene, settings)
    run = order.folder("explore", settings, (scene, *scene_files(world.scene)))
    if not run.is_finished:
        with run.opened():
            _explore_into(run, world, settings, order.progress)
    return read_report(run.path)


def _explore_into(run: RunFolder, world: World, settings: Settings, progress: Progress) -> None:
    began = time.perf_counter()
    recorder = Recorder(run=run, world=world, settings=settings, progress=progress)
    with CloudWriter(run.path / "cloud.ply") as recorder.cloud:
        exploration = explore(world, settings, recorder.observe, recorder.take)
    if exploration.stop_reason == "interrupted":
        run.interrupt()
    _write(run, exploration, recorder.clearest, settings, began)


class Recorder:
    """Keeps what the agent saw: every point, every pair until the end, and the clearest pair."""

    cloud: CloudWriter

    def __init__(
        self, *, run: RunFolder, world: World, settings: Settings, progress: Progress
    ) -> None:
        self.saved = SavedPairs(folder=run.partial)
        self.world = world
        self.max_pairs = settings.exploration.max_pairs
        self.progress = progress
        self.num_taken = 0
        self.clearest: Step | None = None

    def take(self, view: View) -> StereoPair:
        """The pair of the next view: replayed where a cut run had it, else taken and kept."""
        pair = self.saved.load(self.num_taken)
        if pair is None:
            pair = self.world.take(view)
            self.saved.save(self.num_taken, pair)
        self.num_taken += 1
        return pair

    def observe(self, step: Step) -> None:
        """Put the points of one step on disk."""
        self.cloud.append(step.cloud, step.number)
        if self.clearest is None or len(step.matches) > len(self.clearest.matches):
            self.clearest = step
        self.progress(step.number + 1, self.max_pairs)


def _write(
    run: RunFolder,
    exploration: Exploration,
    clearest: Step | None,
    settings: Settings,
    began: float,
) -> None:
    voxels = occupied(exploration.voxel_map, settings.map)
    recognition = with_views(exploration.recognition, voxels, run.path / "cloud.ply")
    trajectory = Trajectory(stamps_s=exploration.stamps_s, T_world_left=exploration.trajectory)
    write_products(run, exploration.voxel_map, recognition, trajectory)
    drawing = time.perf_counter()
    contents = RunContents(voxels=voxels, objects=recognition.objects, trajectory=trajectory)
    seen = None if clearest is None else (clearest.pair.left, clearest.matches)
    leave_figures(run.path, contents, seen)
    ended = time.perf_counter()
    seconds = exploration.seconds | {"figures": ended - drawing, "total": ended - began}
    run.seconds.update(seconds)
    write_metrics(run, exploration.metrics | {"seconds": seconds})
