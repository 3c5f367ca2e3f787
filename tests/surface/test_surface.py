"""Depths confirmed, fused and meshed: exact on a ball and a wall, and nowhere else."""

from dataclasses import replace

import numpy as np
import pytest
from views import COLOUR, HEIGHT, RIG, VOXEL, WIDTH, ball_view, mesh_of, view_of, wall_view

from recon.errors import InputError
from recon.geometry import transform
from recon.records import DisparityMap, Mesh, StereoPair
from recon.settings import SurfaceSettings
from recon.surface.assembly import MeshParts
from recon.surface.cells import CellCloud, joined
from recon.surface.confirmation import Confirmation, confirmed
from recon.surface.depth import depth_map
from recon.surface.fusion import Fusion
from recon.surface.triangles import (
    mesh_of_pixels,
    vertex_pieces,
    without_floaters,
)
from recon.surface.volume import Volume


def test_ball_is_round_and_its_normals_point_outwards(ball):
    radius = np.linalg.norm(ball.vertices, axis=1)
    assert np.median(np.abs(radius - 1)) < 0.1 * VOXEL
    assert abs(np.median(radius - 1)) < 0.05 * VOXEL
    assert 0.75 < ball.area / (4 * np.pi) < 1.02
    outwards = (ball.normals * ball.vertices).sum(axis=1) / radius
    assert np.quantile(outwards, 0.05) > 0.9
    assert MeshParts.of(ball).largest_share > 0.98


def test_same_views_give_the_same_bytes(ball):
    volume = Volume(VOXEL)
    for angle in range(0, 360, 30):
        volume.add(ball_view(angle, noise=0.02, sigma=0.02))
    again = mesh_of(volume)
    assert again.vertices.tobytes() == ball.vertices.tobytes()
    assert again.triangles.tobytes() == ball.triangles.tobytes()


def test_accurate_views_weigh_more_than_uncertain_ones():
    volume = Volume(VOXEL)
    volume.add(wall_view(4.0, sigma=0.01))
    volume.add(wall_view(4.1, sigma=0.4))
    assert np.median(mesh_of(volume).vertices[:, 2]) == pytest.approx(4.0, abs=0.01)
    alike = Volume(VOXEL)
    alike.add(wall_view(4.0, sigma=0.02))
    alike.add(wall_view(4.1, sigma=0.02))
    assert np.median(mesh_of(alike).vertices[:, 2]) == pytest.approx(4.05, abs=0.01)


def test_surface_that_other_views_see_through_is_carved_away():
    floating = np.full((HEIGHT, WIDTH), 4.0)
    floating[20:60, 30:70] = 2.0
    volume = Volume(VOXEL)
    volume.add(view_of(floating, np.eye(4), 0.02))
    before = (mesh_of(volume).vertices[:, 2] < 3).sum()
    for x in (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8):
        volume.add(wall_view(4.0, sigma=0.02, x=x))
    assert before > 100
    assert (mesh_of(volume).vertices[:, 2] < 3).sum() < 0.2 * before


def test_uncertain_depths_and_empty_views_give_no_surface():
    volume = Volume(VOXEL)
    volume.add(wall_view(4.0, sigma=7 * VOXEL))
    volume.add(view_of(np.full((HEIGHT, WIDTH), np.nan), np.eye(4), 0.01))
    assert len(mesh_of(volume)) == 0


def test_too_small_voxels_are_rejected(monkeypatch):
    monkeypatch.setattr("recon.surface.volume._MAX_BLOCKS", 100)
    with pytest.raises(InputError, match="give a larger --voxel"):
        Volume(0.02).add(wall_view())


@pytest.mark.parametrize(
    ("sigma", "fault"),
    [
        (0.02, "would stay empty, as the depths of the first pair have a sigma of 0.02 or more"),
        (0.001, "more than 2000000 blocks"),
    ],
)
def test_hopeless_voxels_are_rejected_at_the_first_view(sigma, fault):
    fusion = Fusion(SurfaceSettings(mesh=True, voxel=2e-4))
    with pytest.raises(InputError, match=fault):
        fusion.add_view(wall_view(sigma=sigma))


def test_small_voxels_need_not_fit_the_first_view():
    fusion = Fusion(SurfaceSettings(mesh=True, voxel=VOXEL))
    for view in (wall_view(sigma=7 * VOXEL), wall_view(x=0.1), wall_view(x=0.2)):
        fusion.add_view(view)
    assert len(fusion.finish().mesh)


def test_watertight_alone_makes_a_mesh():
    fusion = Fusion(SurfaceSettings(watertight=True, voxel=VOXEL))
    for angle in range(0, 360, 30):
        fusion.add_view(ball_view(angle))
    assert len(fusion.finish().mesh)


@pytest.mark.parametrize(("share", "is_kept"), [(0.5, True), (2.0, False)])
def test_depth_that_others_look_through_is_dropped_but_not_one_they_see_hidden(share, is_kept):
    view = wall_view(4.0)
    agreeing, others = [view] * 2, [wall_view(4.0 * share)] * 3
    found = confirmed(view, [*agreeing, *others])
    assert found.valid_mask.all() == found.valid_mask.any() == is_kept
    assert found.num_views.max() == (3 if is_kept else 0)


def test_depths_that_neighbours_see_are_confirmed():
    views = [ball_view(angle, noise=0.01, sigma=0.01) for angle in (0, 10, 20)]
    found = confirmed(views[1], [views[0], views[2]])
    kept, known = found.valid_mask, views[1].valid_mask
    assert kept[known].mean() > 0.9
    assert (found.num_views[kept] >= 2).mean() > 0.9
    assert (found.num_views[~kept] == 0).all()


def test_depths_that_neighbours_contradict_are_dropped():
    views = [wall_view(x=x) for x in (-0.2, -0.1, 0.1, 0.2)]
    depth = np.full((HEIGHT, WIDTH), 4.0)
    depth[30:50, 40:60] = 3.0
    found = confirmed(view_of(depth, np.eye(4), 0.01), views)
    assert np.isnan(found.depth[31:49, 41:59]).all()
    assert np.isfinite(found.depth[5:25, 45:50]).all()


def test_depths_outside_all_other_views_are_kept():
    alone = wall_view()
    assert confirmed(alone, []).valid_mask.all()
    away = view_of(np.full((HEIGHT, WIDTH), 4.0), np.diag([-1.0, 1, -1, 1]), 0.01)
    assert confirmed(alone, [away]).valid_mask.all()


def test_views_are_confirmed_in_order_and_few_are_held():
    line = Confirmation()
    done = []
    for number in range(30):
        done += list(line.add(wall_view(x=0.05 * number)))
        assert len(line._views) <= 13
    done += list(line.finish())
    places = [view.position[0] for view in done]
    np.testing.assert_allclose(places, 0.05 * np.arange(30))


def test_pixels_are_joined_but_not_across_depth_jumps():
    depth = np.full((HEIGHT, WIDTH), 4.0)
    depth[:, 48:] = 2.0
    view = view_of(depth, np.eye(4), 0.01)
    mesh = mesh_of_pixels(view)
    assert np.ptp(mesh.corners[..., 2], axis=1).max() < 0.1
    assert len(mesh) == 2 * (HEIGHT - 1) * (WIDTH - 2)
    assert (mesh.normals[:, 2] < -0.9).all()
    assert vertex_pieces(mesh)[mesh.triangles[:, 0]].max() == 1
    slanted = np.full((HEIGHT, WIDTH), 4.0) + np.arange(WIDTH) * 0.05
    assert len(mesh_of_pixels(view_of(slanted, np.eye(4), 0.01))) == 2 * (HEIGHT - 1) * (WIDTH - 1)


def test_small_pieces_are_removed(ball):
    speck = Mesh(
        vertices=np.concatenate([ball.vertices, [[5.0, 0, 0], [5.1, 0, 0], [5, 0.1, 0]]]),
        triangles=np.concatenate(
            [ball.triangles, len(ball.vertices) + np.array([[0, 1, 2]], np.int32)]
        ),
    )
    kept = without_floaters(speck)
    assert kept.vertices[:, 0].max() < 2
    assert len(kept) > 0.95 * len(ball)
    assert len(without_floaters(Mesh.none())) == 0


def test_points_of_a_cell_are_averaged_and_views_counted():
    cells = CellCloud(0.5)
    for _ in range(3):
        cells.add(wall_view(4.1, sigma=0.2))
    cloud = joined(cells)
    np.testing.assert_allclose(cloud.points[:, 2], 4.1, atol=1e-6)
    np.testing.assert_allclose(cloud.sigma, 0.2 / np.sqrt(3), rtol=1e-6)
    assert (cloud.attributes["views"] == 3).all()
    assert len(np.unique(np.floor(cloud.points / 0.5), axis=0)) == len(cloud)
    assert len(joined(CellCloud(1.0))) == 0


def test_point_takes_the_colour_of_the_nearest_points():
    cells = CellCloud(0.1)
    left, right = wall_view(x=-2.0), wall_view(x=2.0)
    cells.add(left)
    cells.add(replace(right, colours=np.full_like(right.colours, 7)))
    places = np.array([[-2.5, 0.0, 4.0], [2.5, 0.0, 4.02], [-2.5, 0.0, 3.7], [-2.5, 0.0, 2.0]])
    expected = [COLOUR, [7, 7, 7], COLOUR, [0, 0, 0]]
    np.testing.assert_array_equal(cells.colours_at(places), expected)
    assert len(CellCloud(1.0).colours_at(np.zeros((0, 3)))) == 0


def pair_of(disparity, T=None):
    image = np.full((HEIGHT, WIDTH, 3), COLOUR, np.uint8)
    found = DisparityMap(
        disparity_px=np.full((HEIGHT, WIDTH), disparity, np.float32),
        sigma_px=np.full((HEIGHT, WIDTH), 0.1, np.float32),
    )
    return StereoPair(left=image, right=image, rig=RIG, T_world_left=T, name="pair 7"), found


def test_single_pair_gives_one_point_per_pixel():
    fusion = Fusion(SurfaceSettings(mesh=True))
    fusion.add(*pair_of(4.5))
    surface = fusion.finish()
    assert len(surface.cloud) == HEIGHT * WIDTH
    # Without a pose the camera is level and looks along -z in a world whose y is up.
    np.testing.assert_allclose(surface.cloud.points[:, 2], -4.0, atol=1e-6)
    expected = RIG.depth_sigma(4.0, np.hypot(0.13, 0.08))
    np.testing.assert_allclose(surface.cloud.sigma, expected, rtol=1e-5)
    assert surface.metrics["num_triangles"] == len(surface.mesh)
    assert surface.metrics["dense_share"] == 1.0


def test_several_pairs_are_fused_in_the_world_frame():
    fusion = Fusion(SurfaceSettings(mesh=True, voxel=0.1))
    for x in (0.0, 0.1, 0.2):
        T = np.eye(4)
        T[:3, 3] = [x, 5.0, 0.0]
        fusion.add(*pair_of(4.5, T))
    surface = fusion.finish()
    np.testing.assert_allclose(surface.mesh.vertices[:, 2], 4.0, atol=0.02)
    assert surface.mesh.vertices[:, 1].mean() == pytest.approx(5.0, abs=0.1)
    assert (surface.mesh.colours == COLOUR).all()
    assert surface.metrics["dense_confirmed_share"] > 0.95
    assert (surface.cloud.attributes["views"] >= 2).mean() > 0.8


def test_second_pair_needs_a_pose():
    fusion = Fusion(SurfaceSettings())
    fusion.add(*pair_of(4.5))
    with pytest.raises(InputError, match="pair 7 has no pose"):
        fusion.add(*pair_of(4.5))


def test_no_pairs_give_an_empty_surface():
    surface = Fusion(SurfaceSettings(mesh=True)).finish()
    assert len(surface.cloud) == len(surface.mesh) == 0


def test_depth_follows_disparity_and_the_pose():
    pair, found = pair_of(9.0, np.diag([1.0, -1, -1, 1]))
    view = depth_map(pair, found)
    np.testing.assert_allclose(view.depth, 2.0)
    pixels = np.argwhere(view.valid_mask)[:, ::-1]
    points_left = view.rig.triangulate(pixels, np.full(len(pixels), 9.0))
    expected = transform(np.diag([1.0, -1, -1, 1]), points_left)
    np.testing.assert_allclose(view.points(view.valid_mask), expected)


def test_disparity_near_zero_has_no_depth():
    pair, found = pair_of(0.15)
    assert not depth_map(pair, found).valid_mask.any()
