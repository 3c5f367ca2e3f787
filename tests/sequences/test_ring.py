"""Views around an object: pairs by geometry, rotated images, points on the object."""

import cv2
import numpy as np
import pytest

from recon.errors import InputError
from recon.geometry import invert, look_at, transform
from recon.sequences import open_sequence
from recon.sequences.readers.ring import (
    blackened,
    distinct,
    in_turn,
    neighbours,
    read_box,
    read_views,
)
from recon.settings import SequenceSettings

K = np.array([[500.0, 0, 150], [0, 500, 110], [0, 0, 1]])
SIZE = (300, 220)
CENTRE = np.array([0.1, 0.2, -0.1])
DOTS = CENTRE + 0.08 * np.array([[1, 1, 1], [-1, 1, 0], [0.5, -1, 1], [-1, -0.5, -1], [0, 0, 0]])


def camera_at(azimuth_deg, height=0.2, up=(0, 1, 0)):
    a = np.radians(azimuth_deg)
    eye = CENTRE + np.array([2 * np.sin(a), height, 2 * np.cos(a)])
    return look_at(eye, CENTRE, up)


def write_ring(path, poses, readme=True):
    """Write images of a few dots, each with its own grey value, and their par.txt."""
    path.mkdir()
    lines = [str(len(poses))]
    for number, T_world_cam in enumerate(poses):
        image = np.zeros(SIZE[::-1], np.uint8)
        dots = transform(invert(T_world_cam), DOTS)
        places = (K @ dots.T)[:2].T / dots[:, 2:]
        for grey, (u, v) in reversed([*enumerate(places)]):  # the first is in front of all others
            centre = (round(16 * u), round(16 * v))
            cv2.circle(image, centre, 16 * 4, 250 - 40 * grey, -1, cv2.LINE_AA, 4)
        cv2.imwrite(str(path / f"view{number}.png"), image)
        T = invert(T_world_cam)
        values = [*K.ravel(), *T[:3, :3].ravel(), *T[:3, 3]]
        lines.append(f"view{number}.png " + " ".join(f"{value:.15g}" for value in values))
    (path / "toy_par.txt").write_text("\n".join(lines))
    if readme:
        low, high = CENTRE - 0.09, CENTRE + 0.09
        corners = "\n".join(f"({c[0]:.6f} {c[1]:.6f} {c[2]:.6f})" for c in (low, high))
        (path / "README.txt").write_text(f"The (tight) bounding box is\n{corners}\n")
    return path


@pytest.fixture
def ring(tmp_path):
    """Five views 20 degrees apart, one with its camera on its side, and two above each other."""
    poses = [camera_at(20 * n) for n in range(4)]
    poses.append(camera_at(80, up=(1, 0.1, 0)))
    poses += [camera_at(200), camera_at(200, height=0.9)]
    return write_ring(tmp_path / "ring", poses)


def dot_at(image, grey):
    """Find the centre of the largest patch of one grey value."""
    is_dot = (np.abs(image.astype(int) - grey) < 8).astype(np.uint8)
    _, _, sizes, middles = cv2.connectedComponentsWithStats(is_dot)
    return middles[1 + np.argmax(sizes[1:, cv2.CC_STAT_AREA])]


def test_pairs_are_neighbouring_views_and_measure_the_object(ring):
    source = open_sequence(ring, SequenceSettings())
    names = {pair.name for pair in source}
    assert names == {"view0-view1", "view1-view2", "view2-view3", "view3-view4", "view5-view6"}
    for pair in source:
        left, right = (dot_at(image, 250) for image in (pair.left, pair.right))
        assert abs(left[1] - right[1]) < 0.5
        disparity = left[0] - right[0]
        assert 0 <= disparity <= source.disparity_range[1]
        point = pair.rig.triangulate(left[None], np.array([disparity]))
        np.testing.assert_allclose(transform(pair.T_world_left, point)[0], DOTS[0], atol=0.015)


def test_ignoring_unequal_principal_points_misplaces_the_object(ring):
    pair = next(iter(open_sequence(ring, SequenceSettings())))
    assert abs(pair.rig.disparity_offset_px) > 50


def test_pairs_come_in_order_around_the_ring(ring):
    views = read_views(ring / "toy_par.txt")
    pairs = [(a, b) for a, b in neighbours(views, CENTRE)]
    turned = in_turn(pairs[::-1], CENTRE)
    order = [a.path.stem[-1] + b.path.stem[-1] for a, b in turned]
    chain = ["01", "12", "23", "34", "56"]
    double = order + order
    assert any(double[n : n + 5] in (chain, chain[::-1]) for n in range(5))


def test_view_from_the_same_position_is_skipped(tmp_path):
    path = write_ring(tmp_path / "ring", [camera_at(0), camera_at(20), camera_at(0)])
    source = open_sequence(path, SequenceSettings())
    assert len(list(source)) == 1
    assert list(source.skipped) == [("view2", "it has the pose of view0")]
    assert len(distinct(read_views(path / "toy_par.txt"))[0]) == 2


def test_box_without_a_readme_is_where_all_views_look(tmp_path):
    path = write_ring(tmp_path / "ring", [camera_at(a) for a in (0, 20, 90)], readme=False)
    low, high = read_box(path, read_views(path / "toy_par.txt"))
    np.testing.assert_allclose((low + high) / 2, CENTRE, atol=1e-6)
    assert (low < DOTS.min(axis=0)).all()
    assert (high > DOTS.max(axis=0)).all()


def test_views_too_far_apart_are_rejected(tmp_path):
    path = write_ring(tmp_path / "ring", [camera_at(0), camera_at(90)])
    with pytest.raises(InputError, match="no two views 10 to 35 degrees apart"):
        open_sequence(path, SequenceSettings())


def test_invalid_line_is_named(tmp_path):
    path = write_ring(tmp_path / "ring", [camera_at(0), camera_at(20)])
    par = path / "toy_par.txt"
    par.write_text(par.read_text() + "\nview9.png 1 2 3")
    with pytest.raises(InputError, match=r"line 4: 21 numbers .* after view9\.png"):
        open_sequence(path, SequenceSettings())


def test_dark_background_becomes_black_without_an_edge():
    rng = np.random.default_rng(0)
    image = rng.integers(0, 16, (60, 60, 3), np.uint8)
    image[20:40, 20:40] = 200
    black = blackened(image)
    assert (black[:15] == 0).all()
    assert (black[25:35, 25:35] == 200).all()
    ramp = np.tile(np.arange(60, dtype=np.uint8), (20, 1))
    assert np.abs(np.diff(blackened(ramp)[10].astype(int))).max() <= 4


@pytest.mark.data
def test_temple_views_are_paired_by_geometry(data_dir):
    source = open_sequence(data_dir / "middlebury_mvs" / "templeSparseRing", SequenceSettings())
    assert len(source) == 15
    assert [skip[0] for skip in source.skipped] == ["templeSR0011"]
    low, high = source.disparity_range
    assert low == 0
    assert 200 < high < 300
