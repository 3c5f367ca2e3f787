"""Images by ray casting: depth, edges, textures, lighting and the faults of a camera."""

import dataclasses

import numpy as np
import pytest
from PIL import Image

from recon.errors import InputError
from recon.geometry import invert, transform
from recon.records import View
from recon.settings.settings import Settings
from recon.world.render import SKY_RGB
from recon.world.renderers import RENDERERS
from recon.world.visuals import (
    CylinderVisual,
    MeshVisual,
    PolygonVisual,
    Scene,
    Shader,
    SphereVisual,
    Vertex,
)
from recon.world.world import World

AHEAD = View(position=[0.0, 5.0, 0.0], target=[0.0, 5.0, -10.0])
BALL = SphereVisual(centre=(0, 5, -20), radius=4, texture=0)
RED = (1.0, 0.0, 0.0, 1.0)


def wall(z, size=9.0, cull=False, colour=RED):
    corners = ((-1, -1), (1, -1), (1, 1), (-1, 1))
    return PolygonVisual(
        cull_back=cull,
        vertices=tuple(
            Vertex(position=(size * x, 5 + size * y, z), colour=colour, uv=(x, y))
            for x, y in corners
        ),
    )


def sphere_depth(pair, centre, radius):
    """Compute the depth of a sphere analytically."""
    u, v = np.meshgrid(np.arange(256.0), np.arange(256.0))
    rays = pair.rig.rays(np.column_stack([u.ravel(), v.ravel()]))
    middle = np.asarray(centre) - pair.T_world_left[:3, 3]
    middle = pair.T_world_left[:3, :3].T @ middle
    a, b, c = (rays**2).sum(1), rays @ middle, middle @ middle - radius**2
    with np.errstate(invalid="ignore"):
        return ((b - np.sqrt(b**2 - a * c)) / a).reshape(256, 256)


def test_depth_of_a_sphere_matches_the_formula(world_of):
    world = world_of(BALL, textures=("leaves",))
    depth = world.truth(AHEAD).depth
    wanted = sphere_depth(world.take(AHEAD), BALL.centre, BALL.radius)
    assert (np.isfinite(depth) != np.isfinite(wanted)).mean() < 0.001
    error = np.abs(depth - wanted)[np.isfinite(depth) & np.isfinite(wanted)]
    assert np.median(error) < 0.006
    assert np.percentile(error, 99) < 0.03


@pytest.mark.parametrize(
    ("near", "far", "seen"), [(0.1, 100, True), (0.1, 9, False), (11, 100, False)]
)
def test_surfaces_outside_near_and_far_are_clipped(world_of, near, far, seen):
    world = world_of(wall(-10.0), eyes={"near": near, "far": far})
    depth = world.truth(AHEAD).depth
    assert np.isfinite(depth[128, 128]) == seen
    assert (world.take(AHEAD).left[128, 128].tolist() == [255, 0, 0]) == seen
    if seen:
        np.testing.assert_allclose(depth[np.isfinite(depth)], 10, atol=1e-9)


def test_same_view_gives_the_same_bytes(village, world_of):
    noisy = world_of(BALL, textures=("leaves",), render={"noise": 5.0})
    for world in (village, noisy):
        first, second = world.take(AHEAD), world.take(AHEAD)
        np.testing.assert_array_equal(first.left, second.left)
        np.testing.assert_array_equal(first.right, second.right)


def test_culled_polygon_is_invisible_from_behind(world_of):
    far = wall(-20.0, size=30.0, colour=(0.0, 0.0, 1.0, 1.0))
    back = View(position=[0.0, 5.0, -19.0], target=[0.0, 5.0, 0.0])
    for cull, colour in ((True, [round(c) for c in SKY_RGB]), (False, [255, 0, 0])):
        world = world_of(wall(-10.0, cull=cull), far)
        assert world.take(AHEAD).left[128, 128].tolist() == [255, 0, 0]
        assert world.take(back).left[128, 128].tolist() == colour
        assert np.isnan(world.truth(back).depth[128, 128]) == cull


@pytest.mark.parametrize("side", [1, 2, 4, 8])
def test_edge_pixel_is_blended_by_its_coverage(world_of, side):
    world = world_of(wall(-10.0, size=4.03), render={"supersampling": side})
    pair = world.take(AHEAD)
    T_left_world = invert(pair.T_world_left)
    edge = pair.rig.project_left(transform(T_left_world, [[4.03, 5.0, -10.0]]))[0, 0]
    column = round(edge)
    covered = edge - (column - 0.5)
    red, sky = 0.0, SKY_RGB[2]
    shown = (sky - pair.left[128, column, 2]) / (sky - red)
    assert 0.2 < covered < 0.8
    assert abs(shown - covered) <= 0.5 / side + 0.01
    assert shown * side == pytest.approx(round(shown * side), abs=0.02 * side)


def test_mipmaps_remove_aliasing_of_distant_textures(world_of):
    def roughness(mipmaps):
        far = wall(-90.0, size=60.0)
        visual = PolygonVisual(
            cull_back=False,
            texture=0,
            vertices=tuple(
                Vertex(position=v.position, colour=(1, 1, 1, 1), uv=(32 * v.uv[0], 32 * v.uv[1]))
                for v in far.vertices
            ),
        )
        world = world_of(visual, textures=("leaves",), render={"mipmaps": mipmaps})
        return world.take(AHEAD).left[100:156, 100:156][..., 1].astype(float).std()

    assert roughness(True) < 0.2 * roughness(False)
    assert roughness(True) > 0.1


def test_noise_and_blur_have_the_requested_strength(world_of):
    grey = wall(-10.0, size=30.0, colour=(0.5, 0.5, 0.5, 1.0))
    noise = world_of(grey, render={"noise": 6.0}).take(AHEAD)
    assert 5.9 < noise.left.astype(float).std() < 6.1
    together = np.corrcoef(noise.left.ravel(), noise.right.ravel())[0, 1]
    assert abs(together) < 0.02
    other = world_of(grey, render={"noise": 6.0, "noise_seed": 1}).take(AHEAD)
    assert (other.left != noise.left).mean() > 0.8

    edge = wall(-10.0, size=5.0)
    row = {
        blur: world_of(edge, render={"blur_px": blur}).take(AHEAD).left[128, :, 2].astype(float)
        for blur in (0.0, 3.0)
    }
    slope = np.abs(np.diff(row[3.0])).max() / np.ptp(row[3.0])
    assert 0.9 / (3 * np.sqrt(2 * np.pi)) < slope < 1.1 / (3 * np.sqrt(2 * np.pi))
    assert np.abs(np.diff(row[0.0])).max() > 100


def test_fog_attenuates_per_unit_of_distance(world_of):
    image = world_of(wall(-10.0), render={"fog": 0.05}).take(AHEAD).left
    clear = 0.95**10
    wanted = clear * np.array([255, 0, 0]) + (1 - clear) * np.array(SKY_RGB)
    np.testing.assert_allclose(image[128, 128], wanted, atol=0.51)


def test_sky_gets_darker_upwards_if_enabled(world_of):
    plain, deep = (world_of(render={"sky": sky}).take(AHEAD).left[:, 128] for sky in (False, True))
    assert (plain == plain[0]).all()
    assert deep[0, 0] < deep[64, 0] < deep[127, 0]
    np.testing.assert_array_equal(deep[128:], plain[128:])


def test_sun_lights_one_side_and_a_shader_replaces_the_colour(world_of):
    ball = SphereVisual(centre=(0, 5, -20), radius=4)
    lit = world_of(ball, render={"shading": True}).take(AHEAD).left.astype(int)
    assert lit[110, 140, 0] > lit[150, 110, 0] + 20
    green = Shader(
        ambient=(0, 0.2, 0, 1), diffuse=(0, 0.8, 0, 1), specular=(1, 1, 1, 1),
        emissive=(0, 0, 0, 1), shininess=50,
    )  # fmt: skip
    shaded = SphereVisual(centre=(0, 5, -20), radius=4, shader=0)
    for shading, channels in ((True, [0, 2]), (False, [])):
        world = world_of(shaded, shaders=(green,), render={"shading": shading})
        middle = world.take(AHEAD).left[128, 128]
        assert np.flatnonzero(middle == 0).tolist() == channels


def test_textures_are_upright_and_not_mirrored(world_of, tmp_path):
    """A texture whose upper half is blue appears so on upright and lying cylinders."""
    pixels = np.zeros((64, 64, 3), np.uint8)
    pixels[:32, :, 2] = 255  # the upper half blue
    Image.fromarray(pixels).save(tmp_path / "flag.png")
    mast = CylinderVisual(
        radius_base=2, radius_top=2, height=16, translation=(0, 13, -12), texture=0
    )
    scene = Scene(textures=("flag",), visuals=(mast,), folder=tmp_path)
    settings = Settings()
    world = World(scene, settings.eyes, settings.render, settings.world)
    image = world.take(AHEAD).left
    assert image[60, 128, 2] > 200 > 50 > image[190, 128, 2]
    lying = dataclasses.replace(mast, rotation=(0, 1, 0), translation=(-8, 5, -12))
    world = World(
        dataclasses.replace(scene, visuals=(lying,)), settings.eyes, settings.render, settings.world
    )
    image = world.take(AHEAD).left
    assert image[128, 70, 2] > 200 > 50 > image[128, 190, 2]


OBJ = """\
v -3 2 -10
v 3 2 -10
v 3 8 -10
v -3 8 -10
vt 0 0
vt 1 0
vt 1 1
vt 0 1
f 1/1 2/2 3/3 4/4
"""


def test_texture_of_a_mesh_is_upright(tmp_path):
    flag = np.zeros((64, 64, 3), np.uint8)
    flag[:32, :32], flag[:32, 32:], flag[32:, :32] = (255, 0, 0), (0, 255, 0), (0, 0, 255)
    Image.fromarray(flag).save(tmp_path / "flag.png")
    (tmp_path / "board.obj").write_text(OBJ)
    scene = Scene(
        textures=("flag.png",), visuals=(MeshVisual(file="board.obj", texture=0),), folder=tmp_path
    )
    settings = Settings()
    world = World(scene, settings.eyes, settings.render, settings.world)
    image = world.take(AHEAD).left
    quarters = [image[v, u].tolist() for v in (110, 145) for u in (110, 145)]
    assert quarters == [[255, 0, 0], [0, 255, 0], [0, 0, 255], [0, 0, 0]]


def test_gain_and_offset_affect_the_right_camera_only(world_of):
    grey = wall(-10.0, size=30.0, colour=(0.4, 0.4, 0.4, 1.0))
    plain, pair = (
        world_of(grey, render=render).take(AHEAD)
        for render in ({}, {"gain_right": 1.2, "offset_right": -10.0})
    )
    np.testing.assert_array_equal(pair.left, plain.left)
    wanted = np.rint(1.2 * plain.right[128, 128].astype(float) - 10.0)
    np.testing.assert_array_equal(pair.right[128, 128], wanted)


def test_grain_is_as_strong_as_white_noise_but_correlated(world_of):
    grey = wall(-10.0, size=30.0, colour=(0.5, 0.5, 0.5, 1.0))
    images = [
        world_of(grey, render={"noise": 6.0, "noise_grain_px": grain})
        .take(AHEAD)
        .left.astype(float)
        for grain in (0.0, 0.8)
    ]
    white, grain = (image - image.mean() for image in images)
    assert 5.8 < grain.std() < 6.2
    beside = [np.mean(n[:, 1:] * n[:, :-1]) / np.var(n) for n in (white, grain)]
    assert abs(beside[0]) < 0.02
    assert 0.6 < beside[1] < 0.75
    edge = grain[:2].std(), grain[:, -2:].std()
    assert edge == pytest.approx((6.0, 6.0), abs=0.4)


def test_texture_tile_scales_with_the_world(world_of):
    """A world ten times smaller looks the same if its texture tile is ten times smaller."""
    small = SphereVisual(centre=(0, 0.5, -1.2), radius=0.3, texture=0)
    large = SphereVisual(centre=(0, 5.0, -12.0), radius=3.0, texture=0)
    near = View(position=AHEAD.position / 10.0, target=AHEAD.target / 10.0)
    eyes = {"baseline": 0.03, "near": 0.01, "far": 10.0}
    a = world_of(large, textures=("leaves",)).take(AHEAD).left.astype(float)
    b, c = (
        world_of(small, textures=("leaves",), eyes=eyes, render=render)
        .take(near)
        .left.astype(float)
        for render in ({"texture_tile": 1.6}, {})
    )
    assert np.abs(a - b).mean() < 0.5
    assert np.abs(a - c).mean() > 2.0


def test_renderer_is_found_by_name(world_of):
    assert RENDERERS.names()[:2] == ["raycast", "filament"]
    with pytest.raises(InputError, match=r"renderer is 'raycaster', .*nearest: raycast"):
        world_of(BALL, textures=("leaves",), render={"renderer": "raycaster"})
