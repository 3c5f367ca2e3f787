"""Conventions: left and right, up and down, u and v, pixel centres, signs of disparities."""

import cv2
import numpy as np
import pytest

from recon.geometry import invert, transform
from recon.records import View
from recon.world.visuals import PolygonVisual, SphereVisual, Vertex

VIEW = View(position=[2.0, 5.0, -20.0], target=[20.0, 4.0, -5.0])


def ball(x, y, z, radius=0.6):
    return SphereVisual(centre=(x, y, z), radius=radius, texture=0)


def blob_middle(mask):
    rows, columns = np.nonzero(mask)
    return columns.mean(), rows.mean()


def pixels(shape):
    v, u = np.mgrid[: shape[0], : shape[1]].astype(float)
    return np.column_stack([u.ravel(), v.ravel()])


@pytest.mark.parametrize("gaze", ["shift", "toe-in"])
@pytest.mark.parametrize("centre", [(3.0, 7.0, -9.0), (-4.0, 3.5, -12.0), (1.0, 9.5, -25.0)])
def test_ball_is_rendered_where_the_rig_projects_it(world_of, centre, gaze):
    world = world_of(ball(*centre), textures=("checker",), eyes={"gaze": gaze})
    view = world.start()
    pair = world.take(view)
    sky = pair.left[0, 0].astype(int)
    point = transform(invert(pair.T_world_left), [centre])
    for image, projected in (
        (pair.left, pair.rig.project_left(point)[0]),
        (pair.right, pair.rig.project_right(point)[0]),
    ):
        seen = np.abs(image.astype(int) - sky).sum(axis=2) > 60
        # The outline of a ball is an ellipse whose centre lies slightly beyond the ball's.
        assert np.hypot(*(blob_middle(seen) - projected)) < 0.45
    # Right is right, up is up, and the left camera sees objects further to the right.
    u, v = pair.rig.project_left(point)[0]
    assert (u > 127.5) == (centre[0] > 0)
    assert (v < 127.5) == (centre[1] > 5)
    far = -centre[2] > 10
    assert (u < pair.rig.project_right(point)[0, 0]) == far


def test_integer_coordinates_are_pixel_centres(world_of):
    # The edge of a wall on the optical axis lies between pixels 127 and 128.
    white = (1.0, 1.0, 1.0, 1.0)
    corners = [(0, 0, -10), (9, 0, -10), (9, 9, -10), (0, 9, -10)]
    wall = PolygonVisual(
        cull_back=False,
        vertices=tuple(Vertex(position=c, colour=white, uv=(0, 0)) for c in corners),
    )
    world = world_of(wall, eyes={"baseline": 1e-9})
    image = world.take(world.start()).left[100]
    assert (image[128:130] == 255).all()
    assert (image[126:128] < 255).all()
    assert len(np.unique(image[120:136].reshape(-1, 3), axis=0)) == 2


def test_points_of_the_true_depth_lie_on_the_surfaces(village):
    truth = village.truth(VIEW)
    pair = village.take(VIEW)
    uv = pixels(truth.depth.shape)
    z = truth.depth.ravel()
    rays = pair.rig.rays(uv)
    on_object = truth.object_id.ravel() >= 0
    points = transform(pair.T_world_left, (rays * z[:, None])[on_object])
    assert on_object.sum() > 5000
    assert village.clearance(points).max() < 1e-3
    ground = (truth.part_id.ravel() < 0) & np.isfinite(z)
    heights = transform(pair.T_world_left, (rays * z[:, None])[ground])[:, 1]
    np.testing.assert_allclose(heights, 0, atol=1e-4)

    # Rays through the corners of the pixels, or with u and v exchanged, miss.
    shifted = transform(pair.T_world_left, (pair.rig.rays(uv - 0.5) * z[:, None])[on_object])
    turned = transform(pair.T_world_left, (pair.rig.rays(uv[:, ::-1]) * z[:, None])[on_object])
    assert np.percentile(village.clearance(shifted), 99) > 5e-3
    assert np.mean(village.clearance(turned)) > 1


def test_target_has_zero_disparity_and_nearer_points_have_more(village):
    pair = village.take(VIEW)
    target = transform(invert(pair.T_world_left), [VIEW.target])
    np.testing.assert_allclose(pair.rig.project_left(target), [[127.5, 127.5]], atol=1e-9)
    np.testing.assert_allclose(pair.rig.project_right(target), [[127.5, 127.5]], atol=1e-9)
    assert pair.rig.cx_left_px < 127.5 < pair.rig.cx_right_px
    assert pair.rig.disparity(1000.0) < 0 < pair.rig.disparity(2.0)


def warp_error(village, pair, disparity_px):
    truth = village.truth(VIEW)
    u, v = np.meshgrid(np.arange(256.0), np.arange(256.0))
    there = (u - disparity_px).astype(np.float32)
    seen = cv2.remap(pair.right, there, v.astype(np.float32), cv2.INTER_LINEAR).astype(float)
    use = (truth.object_id >= 0) & (there > 1) & (there < 254)
    return np.abs(seen - pair.left)[use].mean()


def test_right_image_is_the_left_one_shifted_by_the_disparity(village):
    pair = village.take(VIEW)
    disparity_px = pair.rig.disparity(village.truth(VIEW).depth)
    right = warp_error(village, pair, disparity_px)
    assert 0.5 < right < 5
    for wrong in (-disparity_px, disparity_px + 1, disparity_px - pair.rig.disparity_offset_px):
        assert warp_error(village, pair, wrong) > 1.5 * right


def test_block_matching_finds_the_true_disparity(village):
    pair = village.take(VIEW)
    truth_px = pair.rig.disparity(village.truth(VIEW).depth)
    grey = [cv2.cvtColor(side, cv2.COLOR_RGB2GRAY) for side in (pair.left, pair.right)]
    matcher = cv2.StereoSGBM.create(-10, 32, 5, 200, 800, uniquenessRatio=10)
    found = matcher.compute(*grey) / 16.0
    use = (village.truth(VIEW).object_id >= 0) & (found > -10)
    error = (found - truth_px)[use]
    assert use.sum() > 3000
    assert np.median(np.abs(error)) < 0.3
    assert abs(np.median(error)) < 0.2
    assert np.median(np.abs(found + truth_px)[use]) > 0.5


@pytest.mark.parametrize("distance", [12.0, 15.0, 23.0, 40.0])
def test_disparity_of_a_wall_is_accurate_to_a_fiftieth_of_a_pixel(world_of, distance):
    corners = ((-1, -1), (1, -1), (1, 1), (-1, 1))
    wall = PolygonVisual(
        cull_back=False,
        texture=0,
        vertices=tuple(
            Vertex(position=(60 * x, 5 + 60 * y, -distance), colour=(1, 1, 1, 1), uv=(4 * x, 4 * y))
            for x, y in corners
        ),
    )
    world = world_of(wall, textures=("leaves",), render={"blur_px": 2.0})
    view = View(position=[0.0, 5.0, 0.0], target=[0.0, 5.0, -30.0])
    pair = world.take(view)
    found_px = shift_between(*(side.astype(float).mean(axis=2) for side in (pair.left, pair.right)))
    assert found_px == pytest.approx(pair.rig.disparity(distance), abs=0.02)


def shift_between(left, right):
    """Estimate the disparity that aligns the right image with the left (Lucas and Kanade)."""
    u, v = np.meshgrid(np.arange(256, dtype=np.float32), np.arange(256, dtype=np.float32))
    inner, found = np.s_[30:-30, 30:-30], 0.0
    for _ in range(30):
        moved = cv2.remap(right.astype(np.float32), u - np.float32(found), v, cv2.INTER_LANCZOS4)
        slope = np.gradient((left + moved) / 2, axis=1)[inner]
        found += ((moved - left)[inner] * slope).sum() / (slope**2).sum()
    return found


def test_toe_in_differs_from_the_sensor_shift_only_by_interpolation(village, world_of):
    turned = world_of(
        *village.scene.visuals, textures=village.scene.textures, eyes={"gaze": "toe-in"},
        shaders=village.scene.shaders,
    )  # fmt: skip
    straight, toed = village.take(VIEW), turned.take(VIEW)
    apart = np.abs(toed.left.astype(float) - straight.left).mean()
    assert 0.05 < apart < 0.6
    assert np.abs(toed.left.astype(float) - straight.right).mean() > 3 * apart
    np.testing.assert_array_equal(turned.truth(VIEW).depth, village.truth(VIEW).depth)


def test_pose_is_the_left_camera_and_position_is_midway(village):
    pair = village.take(VIEW)
    right = pair.T_world_left @ pair.rig.T_left_right
    np.testing.assert_allclose((pair.T_world_left + right)[:3, 3] / 2, VIEW.position, atol=1e-12)
    aside = transform(invert(pair.T_world_left), [VIEW.position])[0]
    np.testing.assert_allclose(aside, [pair.rig.baseline / 2, 0, 0], atol=1e-12)


def test_panes_show_x_to_the_right_and_minus_z_up(world_of):
    world = world_of(ball(60.0, 20.0, -40.0, radius=5.0), textures=("checker",))
    top, front = world.top_view(200), world.front_view(200)
    assert top.shape == (200, 200, 3)
    assert front.shape == (30, 200, 3)
    for pane, middle in ((top, (159.5, 59.5)), (front, (159.5, 9.5))):
        seen = np.abs(pane.astype(int) - pane[0, 0]).sum(axis=2) > 60
        np.testing.assert_allclose(blob_middle(seen), middle, atol=0.3)
