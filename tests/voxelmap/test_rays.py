"""Free space: the same cells as OctoMap, each counted once per scan."""

import numpy as np
import pytest

from recon.errors import InputError
from recon.voxelmap import VoxelMap
from tests.voxelmap.clouds import cloud, observed, random_scans

pyoctomap = pytest.importorskip("pyoctomap")


def sightings_of(scans, cell_size=1.0, ray_margin=0.0):
    return observed(scans, cell_size, ["rays"], ray_margin).sightings()


def octomap_log_odds(scans, cell_size):
    tree = pyoctomap.OcTree(cell_size)
    for points, origin, _ in scans:
        tree.insertPointCloud(points.points, np.asarray(origin, float), lazy_eval=True)
    return {
        tuple(np.floor(np.asarray(leaf.getCoordinate()) / cell_size).astype(int).tolist()):
            leaf.current_node.getLogOdds()
        for leaf in tree.begin_leafs(16)
    }  # fmt: skip


def as_log_odds(sightings):
    values = sightings.hits * np.log(0.7 / 0.3) + sightings.passes * np.log(0.4 / 0.6)
    return dict(zip(map(tuple, sightings.index.tolist()), values.tolist(), strict=True))


@pytest.mark.parametrize("cell_size", [1.0, 0.25])
@pytest.mark.parametrize("seed", range(4))
def test_every_cell_matches_octomap(seed, cell_size):
    # With four scans, no cell reaches the bounds at which OctoMap clamps.
    scans = random_scans(seed, num_scans=4, num=500)
    ours = as_log_odds(sightings_of(scans, cell_size))
    theirs = octomap_log_odds(scans, cell_size)
    assert ours.keys() == theirs.keys()
    assert all(abs(ours[cell] - theirs[cell]) < 1e-5 for cell in ours)


def test_very_wide_scans_match_octomap():
    points = np.vstack([np.random.default_rng(1).normal(scale=9, size=(200, 3)), [[700.5] * 3]])
    scans = [(cloud(points), [0.3, 0.2, 0.1], 0)]
    ours = as_log_odds(sightings_of(scans))
    assert ours.keys() == octomap_log_odds(scans, 1.0).keys()


def test_rays_through_corners_and_along_borders_match_octomap():
    steps = np.array(np.meshgrid([-4, 0, 4], [-4, 0, 4], [-4, 0, 4])).reshape(3, -1).T
    for middle in ([0.5, 0.5, 0.5], [0.25, 0.5, 0.75]):
        scans = [(cloud(middle + steps[np.any(steps != 0, axis=1)]), middle, 0)]
        ours = as_log_odds(sightings_of(scans))
        assert ours.keys() == octomap_log_odds(scans, 1.0).keys()


def test_ray_passes_every_cell_but_the_last():
    sightings = sightings_of([(cloud([[4.5, 0.5, 0.5]] * 9), [0.5, 0.5, 0.5], 0)])
    assert sightings.index[:, 0].tolist() == [0, 1, 2, 3, 4]
    assert sightings.passes.tolist() == [1, 1, 1, 1, 0]
    assert sightings.hits.tolist() == [0, 0, 0, 0, 1]


def test_cell_with_a_point_is_a_hit_even_if_rays_pass_it():
    points = cloud([[6.5, 0.5, 0.5], [3.5, 0.5, 0.5]])
    sightings = sightings_of([(points, [0.5, 0.5, 0.5], 0)])
    assert sightings.hits.tolist() == [0, 0, 0, 1, 0, 0, 1]
    assert sightings.passes.tolist() == [1, 1, 1, 0, 1, 1, 0]


@pytest.mark.parametrize(("sigma", "num_free"), [(0.1, 8), (2.0, 6)])
def test_free_space_ends_one_margin_before_the_point(sigma, num_free):
    points = cloud([[10.25, 0.5, 0.5]], sigma=np.array([sigma]))
    sightings = sightings_of([(points, [0.5, 0.5, 0.5], 0)], ray_margin=1.5)
    # 1.5 cells or two sigma: the cell in which the free part ends is not counted.
    assert np.flatnonzero(sightings.passes).tolist() == list(range(num_free))


def test_long_rays_fit_in_the_buffer():
    far = cloud([[5000.5, 0.5, 0.5], [0.5, -5000.5, 3000.5]])
    sightings = sightings_of([(far, [0.5, 0.5, 0.5], 0)])
    assert sightings.passes.sum() == 5000 + 5001 + 3000 - 1


def test_too_long_ray_is_rejected():
    voxel_map = VoxelMap(1.0, channels=["rays"])
    with pytest.raises(InputError, match="a scan is 2e\\+06 cells wide, but at most 524287"):
        voxel_map.insert(cloud([[2e6, 0, 0]]), [0, 0, 0])
    assert voxel_map.num_cells == 0


@pytest.mark.parametrize("origin", [[0, 0], [0, np.nan, 0]])
def test_invalid_origin_is_rejected(origin):
    with pytest.raises(InputError, match="origin"):
        VoxelMap().insert(cloud([[0, 0, 0]]), origin)


def test_map_without_rays_has_no_sightings():
    with pytest.raises(InputError, match="the map keeps no channels, but rays is needed"):
        VoxelMap().sightings()
