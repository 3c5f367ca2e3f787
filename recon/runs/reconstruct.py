"""A reconstruction, from a recording to a run folder."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np
from scipy.spatial import cKDTree

from recon.errors import InputError
from recon.exports.ply import CloudWriter
from recon.geometry import transform
from recon.localisation.keeper import PlaceKeeper
from recon.manifest import read_manifest
from recon.mapping.mapper import Mapper, Step
from recon.mapping.sparse import match_sparse
from recon.notices import notify
from recon.records import PairSource, Reconstruction, StereoPair
from recon.runs.ahead import match_ahead
from recon.runs.arguments import count, span
from recon.runs.arguments import path as file
from recon.runs.cameras import CAMERAS, SeenCamera, cameras_text
from recon.runs.figure_file import ALWAYS
from recon.runs.figures import NAMELESS, PAIRED, draw_run_figures
from recon.runs.job import Job, Kind, Numbers, Tree
from recon.runs.loading import first_pair
from recon.runs.loops import close_drive, keeps_places, may_close
from recon.runs.maps import ChunkedMap, Map, shown
from recon.runs.outputs import cells_hit, write_outputs, write_places
from recon.runs.parts import part_of, refined_of, without_poses
from recon.runs.surfaces import SurfaceWork
from recon.runs.work import Work
from recon.sequences.contradictions.pairs import check_range
from recon.sequences.contradictions.truth import check_truth, check_truth_size
from recon.sequences.open import open_sequence
from recon.sequences.readers.ring import is_ring
from recon.sequences.readers.simulated import is_simulated
from recon.sequences.truth import DisparityTruth, read_truth
from recon.settings import Settings, updated, with_quality

# Cell size at the median depth, in sigmas of a well-matched point and in pixels; the latter is
# about twice the distance of features.
SIGMAS_TO_CELL = 2.0
SIGMA_PX = 0.15
PIXELS_TO_CELL = 6.0

# Search range if a recording does not state one.
DISPARITY_RANGE = (0, 127)


def _base(job: Job) -> Tree:
    """Settings that a recording suggests: its search range, and a cell size for its depths."""
    (path,) = job.inputs
    # Only images matter here: no poses are needed or estimated.
    read = replace(job.settings.sequence, poses="none", roi=None)
    chosen = Settings(sequence=read)
    # The run itself checks the pairs.
    source = open_sequence(path, chosen.sequence, without_poses(refined_of(job)), checks=False)
    first = first_pair(source, with_quality(chosen, "fast"))
    low, high = source.disparity_range or DISPARITY_RANGE
    search = {"min_disparity": low, "max_disparity": high}
    cell_size = suggested_cell_size(first, updated(chosen, {"matching": search}))
    # Moving objects and wrong matches are seen only once.
    rules = {"occupancy": ("count", "views")} if len(source) > 1 else {}
    return {
        "matching": search,
        "map": {"cell_size": cell_size, "min_count": min(2, len(source)), **rules},
        "recognition": {"ground": None, "catalogue": (), "unit": unit_of(path)},
        "sequence": {"only_confirmed": True} if is_ring(path) else {},
    }


def unit_of(path: Path) -> Literal["m"] | None:
    """Unit of a recording's lengths: calibrations are in metres.

    None if the scale is unknown: for a ring, whose file has its own world, and simulated views.
    """
    no_scale = is_ring(path) or is_simulated(path) or _is_rendered(path)
    return None if no_scale else "m"


def _is_rendered(path: Path) -> bool:
    try:
        return bool(read_manifest(path)["command"] == "render")
    except InputError:
        return False


def suggested_cell_size(pair: StereoPair, settings: Settings) -> float:
    """A cell size that suits the depths of a pair; 1 if it has no matches."""
    matches = match_sparse(pair.left, pair.right, with_quality(settings, "fast")).matches
    depth = pair.rig.depth(matches.disparity_px)
    depth = depth[np.isfinite(depth)]
    if not len(depth):
        return 1.0
    middle = float(np.median(depth))
    deep = SIGMAS_TO_CELL * float(pair.rig.depth_sigma(middle, SIGMA_PX))
    return rounded(max(deep, PIXELS_TO_CELL * middle / pair.rig.focal_px))


def rounded(length: float) -> float:
    """The nearest of ... 0.1, 0.2, 0.5, 1, 2, 5 ..., by ratio."""
    steps = [digit * 10.0**power for power in range(-6, 7) for digit in (1, 2, 5)]
    return float(f"{min(steps, key=lambda step: abs(np.log(step / length))):g}")


def _reconstruct(job: Job, work: Work) -> Numbers:
    """Reconstruct a recording and write its run folder."""
    (path,) = job.inputs
    source = part_of(job, open_sequence(path, job.settings.sequence, refined_of(job)))
    truth = _truth_of(path, next(iter(source)), job.settings) if len(source) == 1 else None
    mapper = Mapper(job.settings, stopwatch=work.stopwatch, counts_views=False, part=source.numbers)
    chunked = ChunkedMap(job.settings.map, work, job.arguments.get("chunk"))
    recorder = Recorder(source, job, work)
    with CloudWriter(work.run.path / "cloud.ply") as cloud:
        for number, (pair, result) in enumerate(match_ahead(source, job.settings, work)):
            num_before = mapper.num_pairs
            if number == 0:
                _check_search(pair, job.settings)
            _note(mapper.process(pair, result), cloud, work)
            counts = mapper.num_pairs > num_before
            recorder.take(pair, counts=counts)
            if counts:
                chunked.take(mapper)
                work.progress(mapper.num_pairs, len(source))
        _note(mapper.finish(), cloud, work)
    work.run.write_text(CAMERAS, cameras_text(recorder.seen))
    loops = close_drive(source, mapper, recorder.places, work)
    if loops.get("num_loops"):  # the map was rebuilt from all points
        chunked.forget()
    num_voxels = _write(mapper, chunked.finish(mapper), work, _figures_of(job))
    if job.settings.map.places:
        write_places(work, recorder.places, mapper.trajectory)
    mapper.reached.say()
    if not mapper.reached.num_triangulated:
        notify("no-points", "no pair gave a point: the images show no edges that match")
    return (
        mapper.metrics
        | {"num_voxels": num_voxels, "num_skipped": len(source.skipped)}
        | _surface_distance(truth, mapper)
        | source.metrics
        | loops
        | recorder.surface.finish(mapper.trajectory, is_part=chunked.chunk is not None)
    )


class Recorder:
    """Records what a run keeps of its pairs besides their points."""

    def __init__(self, source: PairSource, job: Job, work: Work) -> None:
        self.surface = SurfaceWork(job.settings, work, waits=may_close(source))
        self.keeps_places = keeps_places(job.settings)
        self.places = PlaceKeeper()
        self.seen: list[SeenCamera] = []

    def take(self, pair: StereoPair, *, counts: bool) -> None:
        """Record the next pair; one that does not count only confirms the surface of others."""
        self.surface.take(pair, counts=counts)
        if not counts:
            return
        if self.keeps_places:
            self.places.add(pair, len(self.seen))
        self.seen.append(SeenCamera(name=pair.name, rig=pair.rig))


def _check_search(pair: StereoPair, settings: Settings) -> None:
    """Notify if a pair has disparities outside the search range."""
    search = settings.matching.min_disparity, settings.matching.max_disparity
    check_range(pair.left, pair.right, search)


def _note(steps: list[Step], cloud: CloudWriter, work: Work) -> None:
    """Write the points of some steps to disk, and report them."""
    for step in steps:
        with work.stage("write"):
            cloud.append(step.cloud, step.number)
        work.events.on_step(step)


def _figures_of(job: Job) -> Sequence[str]:
    """The figures of a run; of a part only those of a pair: its map is an arbitrary piece."""
    return PAIRED if "part" in job.arguments else ALWAYS


def _write(mapper: Mapper, voxel_map: Map, work: Work, figures: Sequence[str]) -> int:
    """Write the result of all pairs; return the number of occupied cells."""
    run = work.run
    voxels, shown_map = shown(voxel_map, mapper.settings.map)
    nameless = Reconstruction(
        map=shown_map, voxels=voxels, objects=(), trajectory=mapper.trajectory
    )
    with work.stage("figures"):
        early = [name for name in figures if name in NAMELESS]
        draw_run_figures(work, nameless, mapper.clearest, early)
    recognition = mapper.recognise(voxels, cells_hit(run.path / "cloud.ply", voxels.cell_size))
    reconstruction = replace(nameless, objects=recognition.objects)
    with work.stage("figures"):
        named = [name for name in figures if name not in NAMELESS]
        draw_run_figures(work, reconstruction, mapper.clearest, named)
    with work.stage("write"):
        write_outputs(run, reconstruction, recognition)
    with work.stage("figures"):
        work.artist.finish()
    return len(voxels)


def _truth_of(path: Path, pair: StereoPair, settings: Settings) -> DisparityTruth | None:
    """The truth of a single whole pair, read before the work, as a faulty one ends the run."""
    if settings.sequence.roi or not list(path.glob("disp_left.*")):
        return None
    truth = read_truth(path)
    check_truth_size(pair.left, truth)
    return truth


def _surface_distance(truth: DisparityTruth | None, mapper: Mapper) -> dict[str, float]:
    """Median distance of the points to the true surface, for a single pair with truth."""
    step = mapper.clearest
    if truth is None or step is None:
        return {}
    check_truth(step.pair.left, step.matches, truth)
    v, u = np.nonzero(np.isfinite(truth.disparity_px))
    surface = step.pair.rig.triangulate(np.column_stack([u, v]), truth.disparity_px[v, u])
    surface = surface[np.isfinite(surface).all(axis=1)]
    if not len(surface) or not len(step.cloud):
        return {}
    if step.pair.T_world_left is not None:
        surface = transform(step.pair.T_world_left, surface)
    distance, _ = cKDTree(surface).query(step.cloud.points)
    return {"surface_distance_median": float(np.median(distance))}


RECONSTRUCT = Kind(
    run=_reconstruct,
    base=_base,
    takes={"chunk": count, "part": span, "refined": file},
    folder=lambda job: Path("runs") / job.inputs[0].resolve().name,
    stages=("reading", "stereo", "map", "recognise", "figures", "write"),
)
