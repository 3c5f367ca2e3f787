"""A recording of a simulated world, with ground truth."""

from pathlib import Path

import numpy as np

from recon.camera import StereoRig
from recon.exports.formats import write, write_parts
from recon.records import StereoPair
from recon.runs.arguments import text
from recon.runs.job import Job, Kind, Numbers, Tree
from recon.runs.work import Work
from recon.sequences.pfm import write_pfm
from recon.sequences.writing import write_image
from recon.settings import Settings
from recon.surface.cells import CellCloud
from recon.surface.depth import DepthMap
from recon.world.frames import middlebury_calibration
from recon.world.library import find_scene
from recon.world.scene import read_scene
from recon.world.textures import scene_files
from recon.world.views import planned_views
from recon.world.visuals import MeshVisual, Scene
from recon.world.world import Truth, World

MESH_ENDINGS = (".ply", ".obj")


def _render(job: Job, work: Work) -> Numbers:
    """Render a scene from many views; write images, poses, calibration and truth."""
    (path,) = job.inputs
    world = open_world(path, job.settings)
    eyes = job.settings.eyes
    narrow = np.degrees(
        2 * np.arctan(np.tan(np.radians(eyes.fov_deg) / 2) * min(1, eyes.height / eyes.width))
    )
    low, high = world.box
    views = planned_views(job.arguments["views"], low, high, float(narrow))
    recording = _Recording(work.run.path)
    for number, view in enumerate(views):
        with work.stage("render"):
            pair, truth = world.take(view), world.truth(view)
        with work.stage("write"):
            recording.add(number, pair, truth)
        work.progress(number + 1, len(views))
    with work.stage("write"):
        recording.finish()
        write(world.mesh, work.run.path / "scene.ply")
    return {"num_pairs": len(views), "max_disparity": recording.max_disparity}


def open_world(path: Path, settings: Settings) -> World:
    """The world of a geometry file, or of a single mesh."""
    if path.suffix.lower() in MESH_ENDINGS:
        scene = Scene(visuals=(MeshVisual(file=path.name),), folder=path.parent)
        return World(scene, settings.eyes, settings.render, settings.world)
    return World.from_file(path, settings)


class _Recording:
    """A folder readable by `recon reconstruct`, with the truth beside the images."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.max_disparity = 0
        self._poses: list[str] = []
        self._rig: StereoRig | None = None
        self._seen: CellCloud | None = None
        for name in ("left", "right", "disparity", "depth"):
            (folder / name).mkdir(exist_ok=True)

    def add(self, number: int, pair: StereoPair, truth: Truth) -> None:
        """Write one view: images, and disparity and depth of the left one (NaN = nothing)."""
        name = f"{number:06d}"
        disparity = pair.rig.disparity(truth.depth)
        write_image(self.folder / "left" / f"{name}.png", pair.left)
        write_image(self.folder / "right" / f"{name}.png", pair.right)
        write_pfm(self.folder / "disparity" / f"{name}.pfm", disparity)
        write_pfm(self.folder / "depth" / f"{name}.pfm", truth.depth)
        if np.isfinite(disparity).any():
            self.max_disparity = max(self.max_disparity, int(np.ceil(np.nanmax(disparity))))
        assert pair.T_world_left is not None
        self._poses.append(" ".join(map(repr, pair.T_world_left[:3].ravel().tolist())))
        self._rig = pair.rig
        self._note_what_is_seen(pair, truth)

    def _note_what_is_seen(self, pair: StereoPair, truth: Truth) -> None:
        standing = truth.object_id >= 0
        depth = truth.depth if not standing.any() else np.where(standing, truth.depth, np.nan)
        if not np.isfinite(depth).any() or pair.T_world_left is None:
            return
        view = DepthMap(
            depth=depth.astype(np.float32), sigma=np.ones(depth.shape, np.float32),
            colours=pair.left, rig=pair.rig, T_world_left=pair.T_world_left,
        )  # fmt: skip
        if self._seen is None:
            self._seen = CellCloud(float(np.nanmedian(depth)) / pair.rig.focal_px)
        self._seen.add(view)

    def finish(self) -> None:
        """Write calibration, poses, and the cloud of all visible true points."""
        (self.folder / "poses.txt").write_text("\n".join(self._poses) + "\n")
        if self._rig is not None:
            text = middlebury_calibration(self._rig) + f"ndisp={self.max_disparity + 2}\n"
            (self.folder / "calib.txt").write_text(text)
        if self._seen is not None:
            write_parts(self._seen, len(self._seen), self.folder / "seen.ply")


def _base(job: Job) -> Tree:
    return {"render": {"noise_seed": job.seed}}


def _files(job: Job) -> tuple[Path, ...]:
    (path,) = job.inputs
    views = Path(job.arguments["views"])
    named = (views,) if views.is_file() else ()
    if path.suffix.lower() in MESH_ENDINGS:
        return named
    return (*named, *scene_files(read_scene(path)))


def _found(scene: str | Path) -> Path:
    path = Path(scene)
    return path if path.suffix.lower() in MESH_ENDINGS else find_scene(scene)


RENDER = Kind(
    run=_render,
    base=_base,
    find=_found,
    takes={"views": text},
    reads=_files,
    folder=lambda job: Path("runs") / f"{job.inputs[0].stem}_views",
    stages=("render", "write"),
)
