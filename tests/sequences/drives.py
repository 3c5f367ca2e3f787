"""Synthetic tracks of a rig that drives through points, with known motion."""

from scipy.spatial.transform import Rotation

from recon.camera import StereoRig
from recon.geometry import invert, pose, transform
from recon.sequences.calibration.row_error import terms
from recon.sequences.odometry.tracking import Sightings, Tracks

RIG = StereoRig(
    width=1200, height=370, focal_px=700.0, cx_left_px=600.0, cx_right_px=600.0, cy_px=183.0,
    baseline=0.54,
)  # fmt: skip


def motion(rng):
    """Draw `T_first_second`: a step forward and a small rotation."""
    turn = Rotation.from_rotvec(rng.normal(0, 0.01, 3)).as_matrix()
    return pose(turn, rng.normal([0.02, -0.01, 1.2], 0.05))


def tracks(rng, T_first_second, *, number=400, sigma_px=0.1, outliers=0.0, field=None):
    """Make tracks of points 5 to 40 units away; `field` is subtracted from the disparities."""
    depth = rng.uniform(5.0, 40.0, number)
    pixels = rng.uniform([20, 20], [RIG.width - 20, RIG.height - 20], (number, 2))
    points_first = RIG.rays(pixels) * depth[:, None]
    points_second = transform(invert(T_first_second), points_first)
    seen = Tracks(
        first=_seen(rng, points_first, sigma_px, field),
        second=_seen(rng, points_second, sigma_px, field),
    )
    wrong = rng.random(number) < outliers
    seen.second.points_px[wrong] += rng.uniform(-40, 40, (wrong.sum(), 2))
    return seen.select(points_second[:, 2] > 1.0)


def _seen(rng, points_left, sigma_px, field):
    left, right = RIG.project_left(points_left), RIG.project_right(points_left)
    offset = 0.0 if field is None else terms(right, RIG) @ field
    noise = rng.normal(0, sigma_px, (len(left), 4))
    return Sightings(
        points_px=left + noise[:, :2],
        disparity_px=left[:, 0] - right[:, 0] - offset + noise[:, 2],
        row_offset_px=noise[:, 3],
    )
