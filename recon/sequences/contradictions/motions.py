"""Given poses compared with the motions in the images."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import permutations, product

import numpy as np
from numpy.typing import NDArray

from recon.geometry import invert, pose, transform
from recon.records import StereoPair
from recon.sequences.contradictions.pairs import Finding
from recon.sequences.odometry.motion import agreeing_tracks, refine_motion
from recon.sequences.odometry.tracking import Tracks, track

Array = NDArray[np.float64]
Motion = Callable[["Step"], Array]
"""`T_second_first` (4, 4) of a step, by some interpretation of the poses."""

MIN_FLOW_PX = 2.0
"""Median displacement of points in the image below which a rig is at rest."""
EXPLAINED_SHARE = 0.5
"""Maximum share of the displacement unexplained by the poses; inverse poses leave twice as much as
the whole."""
SEEN_SHARE = 0.25
"""Share of the points agreeing on one motion that must agree on another to make it plausible."""
FITTING_SHARE = 0.25
"""Maximum unexplained share for an interpretation of the poses to be suggested."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Step:
    """Two pairs of one rig, and point tracks between them that agree on one motion."""

    first: StereoPair
    second: StereoPair
    tracks: Tracks

    def error_px(self, T_second_first: Array) -> float:
        """Median reprojection error of the points in the second left image under a motion."""
        rig = self.first.rig
        points = rig.triangulate(self.tracks.first.points_px, self.tracks.first.disparity_px)
        moved = transform(T_second_first, points)
        ahead = moved[:, 2] > 1e-6
        if not ahead.any():
            return float("inf")
        error = rig.project_left(moved[ahead]) - self.tracks.second.points_px[ahead]
        return float(np.median(np.linalg.norm(error, axis=1)))

    @property
    def name(self) -> str:
        """Name of the second pair."""
        return self.second.name

    @property
    def flow_px(self) -> float:
        """Median displacement of the points in the left image."""
        return self.error_px(np.eye(4))


def step_between(
    first: StereoPair, second: StereoPair, T_second_first: Array | None = None
) -> Step | None:
    """The step between two posed pairs; None if the images show none.

    Parameters
    ----------
    first, second : StereoPair
    T_second_first : (4, 4), optional
        Motion used to predict the corners.
    """
    if first.rig != second.rig or first.T_world_left is None or second.T_world_left is None:
        return None
    tracks = track(first, second, T_second_first)
    agreeing = agreeing_tracks(tracks, first.rig)
    if agreeing is None:
        return None
    T_second_first, rows = agreeing
    step = Step(first=first, second=second, tracks=tracks.select(rows))
    refined = refine_motion(T_second_first, step.tracks, first.rig)
    if refined is None:
        return None
    return step if step.flow_px > max(MIN_FLOW_PX, 2.0 * step.error_px(refined)) else None


def pose_finding(steps: Sequence[Step]) -> Finding | None:
    """The contradiction between poses and steps; None if they agree or nothing moved."""
    if not steps:
        return None
    left = _unexplained(steps, _given)
    if left <= EXPLAINED_SHARE or _are_seen(steps):
        return None
    fitting = [text for text, share in _readings(steps) if share < FITTING_SHARE]
    advice = f"they fit {', or '.join(fitting)}" if fitting else "try --poses estimated"
    return Finding(
        code="poses-disagree",
        text="poses contradict the images: of the motion in the images, the poses leave "
        f"{left:.0%} unexplained; {advice}",
    )


def _are_seen(steps: Sequence[Step]) -> bool:
    """True if the images also support the motion of the poses.

    Repetitive patterns, such as bricks around a tower, look the same after several motions;
    tracking finds the shortest, unless it starts where the poses predict the corners.
    """
    led = [step_between(step.first, step.second, _given(step)) for step in steps]
    found = [
        one for one, step in zip(led, steps, strict=True)
        if one is not None and len(one.tracks) > SEEN_SHARE * len(step.tracks)
    ]  # fmt: skip
    return 2 * len(found) > len(steps) and _unexplained(found, _given) < FITTING_SHARE


def _unexplained(steps: Sequence[Step], motion: Motion) -> float:
    """Share of the displacement unexplained by a motion: the median over the steps."""
    return float(np.median([step.error_px(motion(step)) / step.flow_px for step in steps]))


def _given(step: Step) -> Array:
    """`T_second_first` of the unchanged poses."""
    assert step.first.T_world_left is not None
    assert step.second.T_world_left is not None
    T: Array = invert(step.second.T_world_left) @ step.first.T_world_left
    return T


def _readings(steps: Sequence[Step]) -> Iterator[tuple[str, float]]:
    """Other interpretations of the poses, and the share of motion each leaves unexplained."""
    turns = [pose(R, np.zeros(3)) for R in _right_angles()]
    for text, motion in (
        ("inverted, as they map the world to the camera", _inverse),
        ("in the opposite order", _backward),
        ("as those of a body whose axes are not the camera's", _given),
    ):
        shares = [_unexplained(steps, _turned(motion, T)) for T in turns]
        yield text, min(shares)


def _turned(motion: Motion, T_body_camera: Array) -> Motion:
    """A motion of a body as that of its camera."""
    return lambda step: invert(T_body_camera) @ motion(step) @ T_body_camera


def _inverse(step: Step) -> Array:
    assert step.first.T_world_left is not None
    assert step.second.T_world_left is not None
    T: Array = step.second.T_world_left @ invert(step.first.T_world_left)
    return T


def _backward(step: Step) -> Array:
    return invert(_given(step))


def _right_angles() -> Iterator[Array]:
    """All 24 rotations (3, 3) by right angles."""
    for order in permutations(range(3)):
        for signs in product((-1.0, 1.0), repeat=3):
            turn = np.diag(signs)[list(order)]
            if np.linalg.det(turn) > 0:
                yield turn
