"""The side from which a round object is seen: texture tells it, or nothing is said."""

import numpy as np
import pytest

from recon.camera import StereoRig
from recon.geometry import invert, pose, transform
from recon.localisation.contest import Contender, decide
from recon.localisation.registration import Contacts, Points, touch
from recon.localisation.stance import tilt_by
from recon.localisation.steps import stepped, turned
from recon.localisation.surfels import Surfels
from recon.localisation.texture import NUM_TILES, Likeness, Texture
from recon.records import PointCloud, PoseEstimate

RIG = StereoRig(
    width=192, height=192, focal_px=114.0, cx_left_px=95.5, cx_right_px=95.5, cy_px=95.5,
    baseline=0.3,
)  # fmt: skip
RADIUS = 3.0


def grey_of(angle, height, repeats):
    """Grey levels round a drum that repeat so many times."""
    phase = repeats * angle
    waves = np.sin(8.0 * phase + 3.0 * np.sin(phase)) * np.sin(2.5 * height + 4.0 * np.cos(phase))
    return 128.0 + 60.0 * waves


def drum(number, repeats, rng):
    """Points on an upright drum with their colours."""
    angle, height = rng.uniform(0.0, 2.0 * np.pi, number), rng.uniform(2.0, 8.0, number)
    points = np.column_stack([RADIUS * np.cos(angle), height, RADIUS * np.sin(angle)])
    grey = grey_of(angle, height, repeats)
    return points, np.repeat(grey[:, None], 3, axis=1).astype(np.uint8)


def view(side):
    """`T_world_left` of a camera that looks at the drum's axis from 9 units away."""
    x, z = -9.0 * np.cos(side), -9.0 * np.sin(side)
    c, s = np.cos(side), np.sin(side)
    turn = np.array([[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]])
    return pose(turn @ tilt_by(0.0), [x, 5.0, z])


def image_of(T_world_left, repeats):
    """The image (H, W) of the drum."""
    rows = np.meshgrid(np.linspace(0.0, 2.0 * np.pi, 900), np.linspace(2.0, 8.0, 250))
    angle, height = (one.ravel() for one in rows)
    points = np.column_stack([RADIUS * np.cos(angle), height, RADIUS * np.sin(angle)])
    grey = grey_of(angle, height, repeats)
    left = transform(invert(T_world_left), points)
    order = np.argsort(-left[:, 2])
    pixel = np.round(RIG.project_left(left[order])).astype(int)
    inside = ((pixel >= 0) & (pixel < 192)).all(axis=1)
    image = np.full((192, 192), 128.0, np.float32)
    image[pixel[inside, 1], pixel[inside, 0]] = grey[order][inside]
    return image


@pytest.fixture(scope="module")
def surfels():
    angle, height = np.meshgrid(np.linspace(0.0, 2.0 * np.pi, 20)[:-1], np.arange(2.5, 8.0))
    points = np.column_stack(
        [RADIUS * np.cos(angle.ravel()), height.ravel(), RADIUS * np.sin(angle.ravel())]
    )
    return Surfels.through(points, 1.0)


def texture_of(repeats, surfels):
    """The texture that four cameras round the drum saw."""
    rng, views = np.random.default_rng(1), []
    for side in np.arange(4) * np.pi / 2:
        points, colours = drum(4000, repeats, rng)
        eye = view(side)[:3, 3]
        facing = points[:, [0, 2]] @ eye[[0, 2]] > RADIUS * RADIUS * 1.2
        cloud = PointCloud(
            points=points[facing], colours=colours[facing], sigma=np.full(facing.sum(), 0.05)
        )
        views.append((cloud, eye))
    return Texture.of(views, surfels)


def test_texture_shows_the_side_and_repeats_with_its_period(surfels):
    true = view(0.3)
    for repeats, same in ((1, (0,)), (2, (0, 180)), (3, (0, 120, 240))):
        texture, image = texture_of(repeats, surfels), image_of(true, repeats)
        value = {
            turn: texture.likeness(image, RIG, turned(true, np.zeros(3), float(turn))).total
            for turn in (0, 40, 80, 120, 180, 240, 300)
        }
        assert {turn for turn, one in value.items() if one > 0.5 * value[0] > 5.0} == set(same)
        others = [one for turn, one in value.items() if turn not in same]
        assert max(others) < 0.15 * value[0]
        assert np.mean(others) < 0.0


def test_texture_that_nobody_saw_says_nothing(surfels):
    assert Texture.of([], surfels) is None
    points, _ = drum(50, 1, np.random.default_rng(0))
    assert Texture.of([(PointCloud(points=points), np.zeros(3))], surfels) is None
    texture = texture_of(1, surfels)
    away = texture.likeness(image_of(view(0.0), 1), RIG, turned(view(0.0), view(0.0)[:3, 3], 180.0))
    assert away.total == 0.0
    assert not away.is_covered.any()


def test_steps_keep_what_they_turn_about():
    centre = np.array([1.0, 0.0, 2.0])
    T = view(0.4)
    about = stepped(T, centre, np.array([30.0, 0.0, 0.0]))
    assert np.isclose(*(np.hypot(*(one[:3, 3] - centre)[[0, 2]]) for one in (T, about)))
    assert np.allclose(stepped(T, centre, np.array([0.0, 30.0, 0.0]))[:3, 3], T[:3, 3])
    nearer = stepped(T, centre, np.array([0.0, 0.0, 0.5]))
    assert np.allclose(nearer[:3, 3], [*((T[:3, 3] + centre) / 2)[:1], 5.0, (T[2, 3] + 2.0) / 2])


def test_points_near_cells_without_a_normal_are_not_off_the_map(surfels):
    rough = Surfels(
        means=surfels.means, normals=surfels.normals, is_flat=surfels.means[:, 1] > 5.0,
        cell_size=1.0, tree=surfels.tree,
    )  # fmt: skip
    points = transform(invert(view(0.0)), surfels.means)
    of = Points(
        points_left=points, sigma=np.full(len(points), 0.1), across=np.full(len(points), 0.1)
    )
    found: Contacts = touch(of, rough, view(0.0), 1.5)
    assert found.num_rough == (surfels.means[:, 1] < 5.0).sum()
    assert found.num_near + found.num_rough == len(points)


def contender(x, shape, tiles, covered=None, sigma=0.05):
    evidence = np.zeros(NUM_TILES**2)
    evidence[: len(tiles)] = tiles
    is_covered = evidence != 0.0 if covered is None else covered
    estimate = PoseEstimate(
        T_world_left=pose(tilt_by(0.0), [x, 5.0, 0.0]), covariance=sigma**2 * np.eye(6),
        probability=0.0, residual=1.0, inlier_share=0.9, num_cells=99,
    )  # fmt: skip
    likeness = Likeness(evidence=evidence, is_covered=is_covered)
    return Contender(estimate=estimate, evidence=shape, likeness=likeness)


def test_a_side_is_said_where_all_others_are_contradicted():
    seen = contender(0.0, 30.0, [4.0, 4.0, 4.0])
    other = contender(9.0, 30.0, [-3.0, -3.0, -3.0])
    said = decide([other, seen], 1.0)
    assert said.T_world_left[0, 3] == 0.0
    assert said.probability > 0.99
    # What is behind it counts as well.
    assert decide([seen, contender(9.0, 0.0, [4.0, 4.0, 4.0])], 1.0)
    # An unseen side may look the same, and so may one that fits less well.
    for same in (contender(9.0, 30.0, []), contender(9.0, 30.0, [2.0, 2.0, 2.0])):
        assert "several" in decide([seen, other, same], 1.0).reason
    assert "exact place" in decide([contender(0.0, 30.0, [4.0], sigma=0.5), other], 1.0).reason
    assert decide([], 1.0).reason == "no place looks like it"
