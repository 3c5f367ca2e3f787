"""The voxel map compared with octomap-python (pip install octomap-python): CPU time."""

import resource
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import octomap

from benchmarks import Measurement, least_cpu_seconds
from recon.records import PointCloud
from recon.voxelmap import VoxelMap

NUM_VIEWS = 20
CELL_SIZES = {"1": 1.0, "0.1": 0.1}


def measure(quick: bool) -> list[Measurement]:
    """Measure speed, memory and disk size; each unit states the required bound."""
    # First, because it measures the peak memory of this process.
    found = [streamed(1_000_000 if quick else 100_000_000)]
    views = scene(100_000 if quick else 1_000_000)
    repeats = 2 if quick else 5
    found += [number for name in CELL_SIZES for number in inserts(name, views, repeats)]
    found.append(one_view(repeats))
    found.append(free_space(views, repeats))
    return found


def scene(num_points: int) -> list[tuple[np.ndarray, PointCloud]]:
    """Make views (eye, points) of ground and 40 round parts in 200 x 30 x 200 units."""
    rng = np.random.default_rng(0)
    middles = np.column_stack([rng.uniform(-95, 95, 40), np.zeros(40), rng.uniform(-95, 95, 40)])
    radii = rng.uniform(1, 8, 40)
    hues = rng.integers(30, 220, (40, 3))
    return [view(rng, num_points // NUM_VIEWS, middles, radii, hues) for _ in range(NUM_VIEWS)]


def view(
    rng: np.random.Generator,
    num: int,
    middles: np.ndarray,
    radii: np.ndarray,
    hues: np.ndarray,
) -> tuple[np.ndarray, PointCloud]:
    """Select the points within about 30 units of an eye near a part."""
    eye = middles[rng.integers(40)] + [rng.uniform(-14, 14), 5.0, rng.uniform(-14, 14)]
    near = np.argsort(np.linalg.norm(middles - eye, axis=1))[:3]
    part = rng.choice(near, num)
    direction = rng.normal(size=(num, 3))
    direction /= np.linalg.norm(direction, axis=1)[:, None]
    points = middles[part] + radii[part][:, None] * (direction + np.array([0, 1, 0]))
    is_ground = rng.random(num) < 0.35
    reach, angle = 26 * np.sqrt(rng.random(num)), rng.uniform(0, 2 * np.pi, num)
    ground = eye * [1, 0, 1] + np.column_stack(
        [reach * np.cos(angle), np.zeros(num), reach * np.sin(angle)]
    )
    points = np.where(is_ground[:, None], ground, points) + rng.normal(scale=0.05, size=(num, 3))
    colours = np.where(is_ground[:, None], 90, hues[part]) + rng.normal(scale=10, size=(num, 3))
    return eye, PointCloud(points=points, colours=np.clip(colours, 0, 255).astype(np.uint8))


def filled(views: list[tuple[np.ndarray, PointCloud]], cell_size: float) -> VoxelMap:
    """Make a map of all views."""
    voxel_map = VoxelMap(cell_size)
    for _, cloud in views:
        voxel_map.insert(cloud)
    return voxel_map


def inserts(
    name: str, views: list[tuple[np.ndarray, PointCloud]], repeats: int
) -> Iterator[Measurement]:
    """Measure insertion, memory and disk size at one cell size."""
    cell_size = CELL_SIZES[name]
    filled(views[:1], cell_size)

    def theirs() -> None:
        tree = octomap.OcTree(cell_size)
        for _, cloud in views:
            tree.updateNodes(cloud.points, True)

    ours = least_cpu_seconds(lambda: filled(views, cell_size), repeats)
    ratio = least_cpu_seconds(theirs, 2) / ours
    bar = {"1": "6, aim 15", "0.1": "4, aim 8"}[name]
    yield Measurement(
        name=f"voxelmap.insert_{name}_speed", value=ratio, better="higher", tolerance=0.3,
        unit=f"x octomap-python's updateNodes (bar {bar})",
    )  # fmt: skip
    voxel_map = filled(views, cell_size)
    yield Measurement(
        name=f"voxelmap.memory_{name}", value=voxel_map.nbytes / voxel_map.num_cells,
        unit="bytes/cell (bar 80, aim 60)", better="lower", tolerance=0.02,
    )  # fmt: skip
    yield disk(name, voxel_map, is_lean=True)
    yield disk(name, voxel_map, is_lean=False)


def disk(name: str, voxel_map: VoxelMap, *, is_lean: bool) -> Measurement:
    """Measure the size of the file."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "map.npz"
        voxel_map.save(path, lean=is_lean)
        size = path.stat().st_size
    what = "index, count, RGB; bar 4, aim 3" if is_lean else "with exact positions; no bar"
    return Measurement(
        name=f"voxelmap.disk_{name}_{'lean' if is_lean else 'exact'}", better="lower",
        value=size / voxel_map.num_cells, unit=f"bytes/cell ({what})", tolerance=0.02,
    )  # fmt: skip


def one_view(repeats: int) -> Measurement:
    """Measure insertion of views of 5,000 points into an existing map, with cells of 1."""
    views = scene(5_000 * NUM_VIEWS)
    kept, tree = filled(views, 1.0), octomap.OcTree(1.0)
    for _, cloud in views:
        tree.updateNodes(cloud.points, True)

    def ours() -> None:
        for _, cloud in views:
            kept.insert(cloud)

    def theirs() -> None:
        for _, cloud in views:
            tree.updateNodes(cloud.points, True)

    return Measurement(
        name="voxelmap.view_5000_time",
        value=least_cpu_seconds(ours, repeats) / least_cpu_seconds(theirs, 2),
        unit="of octomap-python's time (bar 0.2, aim 0.1)", better="lower", tolerance=0.3,
    )  # fmt: skip


def free_space(views: list[tuple[np.ndarray, PointCloud]], repeats: int) -> Measurement:
    """Measure insertion with rays, cells of 1, by OctoMap's rule."""

    def ours() -> None:
        voxel_map = VoxelMap(1.0, channels=["rays"])
        for eye, cloud in views:
            voxel_map.insert(cloud, eye)

    def theirs() -> None:
        tree = octomap.OcTree(1.0)
        for eye, cloud in views:
            tree.insertPointCloud(cloud.points, eye)

    ours()
    return Measurement(
        name="voxelmap.free_space_speed",
        value=least_cpu_seconds(theirs, 1) / least_cpu_seconds(ours, repeats),
        unit="x octomap-python's insertPointCloud (bar 4, aim 8)", better="higher", tolerance=0.3,
    )  # fmt: skip


def streamed(num_points: int) -> Measurement:
    """Measure the growth of this process relative to the map while streaming at cells of 0.1."""
    rng = np.random.default_rng(0)
    chunk = 500_000
    voxel_map = VoxelMap(0.1)
    colours = np.full((chunk, 3), 90, np.uint8)
    places = rng.normal(scale=[4.0, 1.0, 4.0], size=(chunk, 3))
    voxel_map.insert(PointCloud(points=places, colours=colours))
    before, size_before = peak_bytes(), voxel_map.nbytes
    for _ in range(num_points // chunk - 1):
        places = rng.normal(scale=[4.0, 1.0, 4.0], size=(chunk, 3))
        voxel_map.insert(PointCloud(points=places, colours=colours))
    growth = (peak_bytes() - before) / max(voxel_map.nbytes - size_before, 1)
    return Measurement(
        name="voxelmap.streamed_growth", value=growth, better="lower", tolerance=0.3,
        unit=f"x the growth of the map, {num_points:.0e} points",
    )  # fmt: skip


def peak_bytes() -> int:
    """Peak memory of this process."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
