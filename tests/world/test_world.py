"""The simulator: its objects, its truth, and distances to its surfaces."""

import dataclasses

import cv2
import numpy as np
import pytest

from recon.errors import InputError
from recon.records import View
from recon.sequences.open import open_sequence
from recon.settings.sequences import SequenceSettings
from recon.settings.settings import Settings
from recon.world.generator import plain_ground
from recon.world.visuals import (
    CylinderVisual,
    EllipsoidVisual,
    MeshVisual,
    PolygonVisual,
    Scene,
    SphereVisual,
    Vertex,
)
from recon.world.world import World

from .conftest import SCENES
from .test_solids import TETRAHEDRON


def upright(radius, height, x=0.0, top=None, upper=None):
    return CylinderVisual(
        radius_base=radius if upper is None else upper,
        radius_top=radius,
        height=height,
        translation=(x, height if top is None else top, 0),
    )


def test_agent_starts_at_the_centre_looking_along_minus_z(village):
    view = village.start()
    np.testing.assert_array_equal(view.position, [0, 5, 0])
    ahead = view.target - view.position
    assert ahead[2] < 0
    assert ahead[:2].tolist() == [0, 0]


def test_village_has_its_six_objects(village):
    found = {(o.label, *o.centre.round(9)): o.size.round(2).tolist() for o in village.objects}
    assert found == {
        ("apple tree", 10, 8, 20): [8, 16, 8],
        ("apple tree", -10, 8, -30): [8, 16, 8],
        ("apple tree", -40, 8, 5): [8, 16, 8],
        ("pine tree", -10, 8, -5): [16, 16, 16],
        ("pine tree", -40, 8, -30): [16, 16, 16],
        ("cottage", 20, 5.5, -5): [14, 11, 14],
    }
    assert [o.id for o in village.objects] == list(range(6))
    assert sorted(number for o in village.objects for number in o.visuals) == list(range(12))


@pytest.mark.parametrize(
    ("name", "labels"),
    [
        ("three_kinds", ["apple tree", "pine tree", "cottage"]),
        ("three_apples", ["apple tree", "apple tree", "apple tree"]),
        ("square", ["house", "table", "bench", "lamp post", "lamp post", "apple tree"]),
    ],
)
def test_other_scenes_have_the_expected_objects(name, labels):
    world = World.from_file(SCENES / f"{name}.scene", Settings())
    assert [o.label for o in world.objects] == labels
    assert world.clearance([world.start().position])[0] > 10


def test_parts_form_an_object_if_coaxial_and_touching(world_of):
    apart = world_of(upright(2, 8), SphereVisual(centre=(0, 14, 0), radius=4))
    beside = world_of(upright(2, 8), SphereVisual(centre=(2, 12, 0), radius=4))
    stacked = world_of(SphereVisual(centre=(0.2, 12, 0), radius=4), upright(2, 8))
    assert [o.label for o in apart.objects] == ["unknown", "unknown"]
    assert [o.label for o in beside.objects] == ["unknown", "unknown"]
    assert [(o.label, o.visuals) for o in stacked.objects] == [("apple tree", (1, 0))]


def test_objects_that_touch_sideways_stay_separate(world_of):
    world = world_of(
        upright(2, 8, x=-4.0), SphereVisual(centre=(-4, 12, 0), radius=4),
        upright(2, 8, x=4.0), SphereVisual(centre=(4, 12, 0), radius=4),
    )  # fmt: skip
    assert [o.label for o in world.objects] == ["apple tree"] * 2


@pytest.mark.parametrize(
    ("crown", "label"),
    [
        (EllipsoidVisual(centre=(0, 11, 0), radii=(4, 3, 4)), "apple tree"),
        (upright(8, 6, top=14, upper=1), "pine tree"),
        (upright(3, 6, top=14, upper=1), "cottage"),
        (upright(4, 6, top=14), "unknown"),
    ],
)
def test_crown_on_a_body_is_labelled(world_of, crown, label):
    assert [o.label for o in world_of(upright(2, 8), crown).objects] == [label]


def test_lying_or_floating_parts_are_unlabelled_and_not_ground(world_of):
    body, crown = upright(2, 8), SphereVisual(centre=(0, 12, 0), radius=4)
    lying = dataclasses.replace(body, rotation=(0, 0, 0), translation=(0, 6, -4))
    assert [o.label for o in world_of(lying, crown).objects] == ["unknown"]
    corners = ((-5, 9, -5), (-5, 9, 5), (5, 9, 5), (5, 9, -5))
    awning = PolygonVisual(
        cull_back=False,
        vertices=tuple(Vertex(position=c, colour=(1, 1, 1, 1), uv=(0, 0)) for c in corners),
    )
    world = world_of(awning, plain_ground())
    assert [o.visuals for o in world.objects] == [(0,)]
    assert not world.free_ground()[100, 100]


def test_empty_and_invalid_queries(village):
    assert village.clearance(np.empty((0, 3))).shape == (0,)
    with pytest.raises(InputError, match=r"positions has shape \(3,\), but \(N, 3\) is needed"):
        village.clearance([1.0, 2.0, 3.0])
    with pytest.raises(InputError, match="positions holds nan"):
        village.clearance([[1.0, np.nan, 3.0]])
    with pytest.raises(InputError, match="size is 0 pixels"):
        village.top_view(0)


def test_truth_identifies_objects_and_parts(village):
    truth = village.truth(View(position=[2, 5, -20], target=[20, 4, -5]))
    assert truth.depth.shape == truth.object_id.shape == truth.part_id.shape == (256, 256)
    assert truth.object_id.dtype == truth.part_id.dtype == np.int32
    cottage = village.objects[1]
    seen = truth.object_id == cottage.id
    assert set(np.unique(truth.part_id[seen])) == set(cottage.visuals)
    assert truth.part_id[100, 128] == 3  # the roof is above the walls
    assert truth.part_id[150, 128] == 2
    assert truth.part_id[250, 10] == -1
    assert np.isfinite(truth.depth[250, 10])
    assert np.isnan(truth.depth[0, 128])


def test_clearance_is_the_distance_to_the_nearest_object(village):
    # Trunk of radius 2 at (10, 20); the crown's centre is at (10, 12, 20).
    points = [[10, 4, 26], [10, 12, 30], [10, 4, 20], [500, 0, 500]]
    clearance = village.clearance(points)
    np.testing.assert_allclose(clearance[:3], [4, 6, 2], atol=0.01)
    assert clearance[3] > 600
    assert village.surface_distance(points)[3] == pytest.approx(0, abs=1e-4)
    assert village.is_inside(points).tolist() == [False, False, True, False]


def test_free_ground_is_the_floor_outside_the_footprints(village):
    free = village.free_ground()
    assert free.shape == (200, 200)
    x, z = np.meshgrid(np.arange(200) - 99.5, np.arange(200) - 99.5, indexing="ij")
    wanted = np.ones_like(free)
    for found in village.objects:
        radius = found.size[0] / 2
        wanted &= np.hypot(x - found.centre[0], z - found.centre[2]) > radius
    assert (free != wanted).sum() < 12
    assert (free != wanted.T).sum() > 100


def test_view_overrides_the_camera_settings(village):
    view = village.start()
    wide = village.take(dataclasses.replace(view, fov_deg=100.0)).rig
    long = village.take(dataclasses.replace(view, focal_length=0.2)).rig
    plain = village.take(view).rig
    assert long.focal_px == pytest.approx(2 * plain.focal_px)
    assert wide.focal_px == pytest.approx(128 / np.tan(np.radians(50)))
    assert village.take(dataclasses.replace(view, baseline=0.5)).rig.baseline == 0.5
    assert not np.isfinite(village.truth(dataclasses.replace(view, far=5.0)).depth[60]).any()


@pytest.mark.parametrize(
    ("view", "message"),
    [
        ({"position": [np.nan, 5, 0]}, "view position holds nan"),
        ({"target": [0, np.inf, 0]}, "view target holds inf"),
        ({"target": [0, 5, 0]}, "gives no horizontal direction"),
        ({"target": [0, 50, 0]}, "gives no horizontal direction"),
        ({"baseline": -1.0}, r"view with \{'baseline': -1.0\}.*a number > 0 is needed"),
        ({"fov_deg": 180.0}, r"view with \{'fov_deg': 180.0\}.*a number < 180 is needed"),
        ({"near": 200.0}, "near 200.0 is not nearer than far 100.0"),
    ],
)
def test_invalid_view_is_rejected_in_one_line(village, view, message):
    bad = dataclasses.replace(village.start(), **view)
    for look in (village.take, village.truth):
        with pytest.raises(InputError, match=message) as caught:
            look(bad)
        assert "\n" not in str(caught.value)


@pytest.mark.parametrize("visuals", [(), (plain_ground(),)], ids=["nothing", "ground"])
def test_world_without_objects(world_of, visuals):
    world = world_of(*visuals)
    view = world.start()
    pair = world.take(view)
    assert world.objects == ()
    assert pair.left.shape == (256, 256, 3)
    assert (world.truth(view).object_id == -1).all()
    assert np.isinf(world.clearance([view.position])).all()
    assert world.free_ground().all()
    assert not world.is_inside([view.position]).any()
    assert world.top_view(64).shape == (64, 64, 3)


def test_object_at_the_start_is_detected(world_of):
    world = world_of(upright(7, 8))
    assert world.is_inside([world.start().position]).all()
    assert world.clearance([world.start().position])[0] == pytest.approx(5.8, abs=1.3)
    assert world.take(world.start()).left.shape == (256, 256, 3)


def test_floor_larger_than_memory_is_rejected(world_of):
    world = world_of(plain_ground(), floor={"size_x": 1e6, "size_z": 1e6})
    with pytest.raises(InputError, match="the floor is 1000000 x 1000000 cells, but at most"):
        world.free_ground()


def test_mesh_is_an_object(tmp_path):
    (tmp_path / "rock.ply").write_text(TETRAHEDRON.replace("0 0 1 255", "0 0 -9 255"))
    scene = Scene(visuals=(MeshVisual(file="rock.ply"),), folder=tmp_path)
    settings = Settings()
    world = World(scene, settings.eyes, settings.render, settings.world)
    assert [o.label for o in world.objects] == ["unknown"]
    view = View(position=[0.2, 0.2, 9], target=[0.2, 0.2, 0])
    assert world.take(view).left[128, 128].tolist() == [255, 0, 0]


def test_exported_frame_is_a_pair_with_ground_truth(village, tmp_path):
    village.export_frame(village.start(), tmp_path / "frame")
    names = sorted(path.name for path in (tmp_path / "frame").iterdir())
    assert names == ["calib.txt", "disp_left.pfm", "left.png", "right.png"]
    pair = village.take(village.start())
    left = cv2.imread(str(tmp_path / "frame" / "left.png"))[..., ::-1]
    np.testing.assert_array_equal(left, pair.left)
    disparity = cv2.imread(str(tmp_path / "frame" / "disp_left.pfm"), cv2.IMREAD_UNCHANGED)
    wanted = pair.rig.disparity(village.truth(village.start()).depth)
    np.testing.assert_allclose(disparity[np.isfinite(disparity)], wanted[np.isfinite(wanted)], 1e-5)
    (again,) = open_sequence(tmp_path / "frame", SequenceSettings())
    assert again.rig.baseline == pytest.approx(pair.rig.baseline)
    assert again.rig.cx_right_px == pytest.approx(pair.rig.cx_right_px)
    assert again.rig.residual_px == pair.rig.residual_px == 0.0
    np.testing.assert_array_equal(again.right, pair.right)
