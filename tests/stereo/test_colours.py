"""At outlines, points have the colour of their surface, not of what is behind it."""

import cv2
import numpy as np
import pytest

from recon.camera import StereoRig
from recon.records import Matches, StereoPair
from recon.settings import TriangulationSettings
from recon.stereo.triangulation import triangulate

SHAPE = (96, 160)
RIG = StereoRig(
    width=160, height=96, focal_px=80, cx_left_px=80, cx_right_px=80, cy_px=48, baseline=0.5
)
DISPARITY_PX = 12
ROWS, COLUMNS = slice(24, 72), slice(60, 110)
RED, BLUE, GREEN = (170.0, 60.0, 50.0), (120.0, 160.0, 215.0), (150.0, 220.0, 150.0)


def sky():
    """Render a blue that changes slowly from row to row, as seen by both cameras."""
    fade = np.linspace(-15, 15, SHAPE[0])[:, None, None]
    image = np.broadcast_to(np.array(BLUE) + fade, (*SHAPE, 3))
    return image, image


def wall(disparity_px=4):
    """Render a bright green texture far behind."""
    image = textured(GREEN, (SHAPE[0], SHAPE[1] + disparity_px), contrast=0.08, seed=2)
    return image[:, : SHAPE[1]], image[:, disparity_px:]


def textured(colour, shape, contrast=0.25, seed=1):
    texture = cv2.GaussianBlur(np.random.default_rng(seed).normal(size=shape), (0, 0), 1.2)
    return np.array(colour) * (1 + contrast * texture / texture.std())[..., None]


def pair_before(background, contrast=0.25, noise=1.0, offset_right=0.0, nearer_px=0):
    """Render a red square in front of a background, its texture nearer than its outline."""
    rng = np.random.default_rng(3)
    left, right = (image.copy() for image in background)
    square = textured(RED, (ROWS.stop - ROWS.start, COLUMNS.stop - COLUMNS.start), contrast)
    left[ROWS, COLUMNS] = square
    seen_right = np.roll(square, -nearer_px, axis=1)
    right[ROWS, COLUMNS.start - DISPARITY_PX : COLUMNS.stop - DISPARITY_PX] = seen_right
    left, right = (
        np.clip(np.rint(image + rng.normal(0, noise, image.shape)), 0, 255).astype(np.uint8)
        for image in (left, right + offset_right)
    )
    return StereoPair(left=left, right=right, rig=RIG)


def outline_points():
    """List the pixels on both sides of the square's border, away from its corners."""
    v, u = np.arange(ROWS.start + 8, ROWS.stop - 8), np.arange(COLUMNS.start + 8, COLUMNS.stop - 8)
    upright = [(x, y) for x in beside(COLUMNS) for y in v]
    level = [(x, y) for y in beside(ROWS) for x in u]
    return np.array(upright + level, dtype=float)


def beside(borders):
    return borders.start - 1, borders.start, borders.stop - 1, borders.stop


def coloured(pair, points_px, is_whole=False, **settings):
    number = len(points_px)
    matches = Matches(
        points_px=points_px,
        disparity_px=np.full(number, float(DISPARITY_PX)),
        sigma_px=np.full(number, 0.1),
        is_whole=np.full(number, is_whole),
        score=np.ones(number),
    )
    found = triangulate(matches, pair, TriangulationSettings(**settings))
    assert len(found.sure) in (0, number)
    return np.concatenate([found.sure.colours, found.doubtful.colours]).astype(float)


def share_behind(colours, behind):
    """Estimate the share of the colour behind in mixtures with the square's."""
    across = np.array(behind) - np.array(RED)
    return (colours - np.array(RED)) @ across / (across @ across)


@pytest.mark.parametrize("offset_right", [0.0, 12.0])
@pytest.mark.parametrize(("background", "behind"), [(sky, BLUE), (wall, GREEN)])
def test_outline_has_the_colour_of_its_surface(background, behind, offset_right):
    pair = pair_before(background(), offset_right=offset_right)
    share = share_behind(coloured(pair, outline_points()), behind)
    assert -0.1 < np.median(share) < 0.1
    assert np.mean(share > 0.5) < 0.06


def test_outline_of_a_round_surface_has_its_colour():
    """Its two outlines are different lines on it, before which its texture lies."""
    pair = pair_before(sky(), nearer_px=1)
    share = share_behind(coloured(pair, outline_points()), BLUE)
    assert np.median(share) < 0.1
    assert np.mean(share > 0.5) < 0.06


def test_doubtful_points_keep_the_mean_of_their_square():
    """Their disparity may be wrong, so it cannot tell the surface from what is behind."""
    pair = pair_before(sky())
    share = share_behind(coloured(pair, outline_points(), is_whole=True), BLUE)
    assert 0.4 < np.median(share) < 0.7


def test_plain_surface_before_a_plain_sky_keeps_the_mean_of_its_square():
    """Nothing tells which of them is near."""
    pair = pair_before(sky(), contrast=0.0)
    share = share_behind(coloured(pair, outline_points()), BLUE)
    assert 0.4 < np.median(share) < 0.7


def test_points_inside_a_surface_have_its_colour_mostly_the_mean_of_their_square():
    pair = pair_before(sky(), noise=0.0)
    inside = np.array([(u, v) for u in range(75, 96, 3) for v in range(39, 58, 3)], dtype=float)
    u, v = inside.astype(int).T
    mean = cv2.blur(pair.left, (3, 3))[v, u].astype(float)
    found = coloured(pair, inside)
    assert np.abs(share_behind(found, BLUE)).max() < 0.25
    assert np.mean(np.abs(found - mean).max(axis=1) <= 1) > 0.4


def test_grey_images_give_grey_points():
    pair = pair_before(sky())
    grey = [cv2.cvtColor(image, cv2.COLOR_RGB2GRAY) for image in (pair.left, pair.right)]
    pair = StereoPair(left=grey[0], right=grey[1], rig=RIG)
    found = coloured(pair, outline_points())
    assert (found == found[:, :1]).all()
    dark, bright = (np.array(colour) @ (0.299, 0.587, 0.114) for colour in (RED, BLUE))
    assert dark - 15 < np.median(found) < dark + 0.15 * (bright - dark)


@pytest.mark.parametrize("side_px", [1, 2, 51])
def test_windows_of_any_size_and_place(side_px):
    corners = np.array([(12, 0), (159, 95), (12, 95), (159, 0), (80, 48)], dtype=float)
    found = coloured(pair_before(sky()), corners, colour_window_px=side_px)
    assert found.shape == (5, 3)
    assert np.abs(found[:4] - np.array(BLUE)).max() < 60
