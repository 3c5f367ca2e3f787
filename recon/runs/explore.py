"""An exploration, from a scene file to a run folder."""

from pathlib import Path

from recon.exploration.agent import explore
from recon.exploration.outcome import Exploration, Step
from recon.exports.ply import CloudWriter
from recon.geometry import Array
from recon.localisation.keeper import PlaceKeeper
from recon.mapping.views import with_views
from recon.notices import notify
from recon.records import StereoPair, View
from recon.records.objects import from_json
from recon.runfolder import RunFolder
from recon.runs.cameras import CAMERAS, SeenCamera, cameras_text
from recon.runs.figures import draw_run_figures
from recon.runs.job import Job, Kind, Numbers, Tree
from recon.runs.outputs import cells_hit, move_cloud, write_outputs, write_places
from recon.runs.replay import SavedPairs
from recon.runs.report import read_json
from recon.runs.surfaces import SurfaceWork
from recon.runs.work import Work
from recon.runs.worlds import judged_names
from recon.settings import EXPLORER_BASE, merged
from recon.world.library import find_scene
from recon.world.scene import read_scene
from recon.world.textures import scene_files
from recon.world.world import World


def _base(job: Job) -> Tree:
    seeds = {stage: {"noise_seed": job.seed} for stage in ("render", "motion")}
    return merged(EXPLORER_BASE, seeds)


def _files(job: Job) -> tuple[Path, ...]:
    (scene,) = job.inputs
    return tuple(scene_files(read_scene(scene)))


def _explore(job: Job, work: Work) -> Numbers:
    """Explore a world and write its run folder."""
    (scene,) = job.inputs
    world = World.from_file(scene, job.settings)
    recorder = Recorder(world, job, work)
    with CloudWriter(work.run.path / "cloud.ply") as recorder.cloud:
        done = explore(world, job.settings, recorder.observe, recorder.take, work.stopwatch)
    if done.stop_reason == "controller failed":
        notify("controller-failed", done.message)
    if done.stop_reason == "interrupted":
        work.run.interrupt()
    work.run.write_text(CAMERAS, cameras_text(recorder.seen))
    move_cloud(work.run.path / "cloud.ply", recorder.poses, done.reconstruction.trajectory)
    _write(done, work)
    if job.settings.map.places:
        write_places(work, recorder.places, done.reconstruction.trajectory)
    return done.metrics | recorder.surface.finish(done.reconstruction.trajectory)


class Recorder:
    """Records the agent's observations: every point, and every pair until the end."""

    cloud: CloudWriter

    def __init__(self, world: World, job: Job, work: Work) -> None:
        self.saved = SavedPairs(folder=work.run.partial)
        self.world = world
        self.work = work
        self.num_taken = 0
        self.poses: list[Array] = []
        """Poses of the left camera used for the points on disk."""
        self.keeps_places = job.settings.map.places
        self.places = PlaceKeeper()
        self.most_known = 0.0
        self.seen: list[SeenCamera] = []
        self.surface = SurfaceWork(job.settings, work, waits=not job.settings.motion.is_exact)

    def take(self, view: View) -> StereoPair:
        """The pair of the next view: replayed from an interrupted run, else taken and saved."""
        pair = self.saved.load(self.num_taken)
        if pair is None:
            pair = self.world.take(view)
            self.saved.save(self.num_taken, pair)
        self.num_taken += 1
        return pair

    def observe(self, step: Step) -> None:
        """Write the points of one step to disk, and report progress."""
        with self.work.stage("write"):
            self.cloud.append(step.cloud, step.number)
        assert step.pair.T_world_left is not None
        self.poses.append(step.pair.T_world_left)
        if self.keeps_places:
            with self.work.stage("write"):
                self.places.add(step.pair, step.number)
        self.surface.take(step.pair)
        self.seen.append(SeenCamera(name=f"{step.number:06d}", rig=step.pair.rig))
        self.work.events.on_step(step)
        self.most_known = max(self.most_known, step.known_share)
        self.work.progress(round(100 * self.most_known), 100)


def _write(done: Exploration, work: Work) -> None:
    run: RunFolder = work.run
    voxels = done.reconstruction.voxels
    with work.stage("recognise"):
        cells = cells_hit(run.path / "cloud.ply", voxels.cell_size)
        recognition = with_views(done.recognition, voxels, cells)
    with work.stage("write"):
        write_outputs(run, done.reconstruction, recognition)
        if done.true_trajectory is not None:
            run.write_text("trajectory_true.txt", done.true_trajectory.as_tum())
    with work.stage("figures"):
        draw_run_figures(work, done.reconstruction, done.clearest)
        work.artist.finish()


def _judged(job: Job, run_path: Path) -> list[tuple[str, str]]:
    """The true names of the world's objects, with the names given by the run."""
    world = World.from_file(job.resolved().inputs[0], job.settings)
    found = from_json(read_json(run_path / "objects.json"))
    return [(one.true, one.found) for one in judged_names(world.objects, found)]


EXPLORE = Kind(
    run=_explore,
    judged=_judged,
    base=_base,
    find=find_scene,
    reads=_files,
    folder=lambda job: Path("runs") / job.inputs[0].stem,
    stages=("render", "stereo", "map", "plan", "recognise", "figures", "write"),
)
