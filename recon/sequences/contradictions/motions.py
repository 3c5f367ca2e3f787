"""Given poses compared with the motions in the images."""

from collections.abc import Callable, Iterator, Sequence
from itertools import permutations, product

import numpy as np
from numpy.typing import NDArray

from recon.geometry import invert, pose
from recon.sequences.contradictions.finding import Finding
from recon.sequences.contradictions.steps import Step, step_between

Array = NDArray[np.float64]
Motion = Callable[[Step], Array]
"""`T_second_first` (4, 4) of a step, by some interpretation of the poses."""

EXPLAINED_SHARE = 0.5
"""Maximum share of the displacement unexplained by the poses; inverse poses leave twice as much as
the whole."""
SEEN_SHARE = 0.25
"""Share of the points agreeing on one motion that must agree on another to make it plausible."""
FITTING_SHARE = 0.25
"""Maximum unexplained share for an interpretation of the poses to be suggested."""
MAX_SCALE = 1.15
"""Maximum ratio, either way, of lengths in the poses and in the images; a pixel of disparity that
the rectification left makes a tenth."""
SCALE_GAIN = 0.1
"""Share of the displacement that the ratio must explain."""
SCALE_SPREAD = 0.3
"""Maximum deviation of a step from the common ratio, as a share of the latter (both logarithms)."""


def pose_finding(steps: Sequence[Step]) -> Finding | None:
    """The contradiction between poses and steps; None if they agree or nothing moved."""
    if not steps:
        return None
    left, scale = _unexplained(steps, _given), _scale(steps)
    if (left <= EXPLAINED_SHARE and scale == 1.0) or _are_seen(steps):
        return None
    fitting = [text for text, share in _readings(steps, scale) if share < FITTING_SHARE]
    advice = f"they fit {', or '.join(fitting)}" if fitting else "try --poses estimated"
    return Finding(
        code="poses-disagree",
        text="poses contradict the images: of the motion in the images, the poses leave "
        f"{left:.0%} unexplained; {advice}",
    )


def _scale(steps: Sequence[Step]) -> float:
    """Ratio of the lengths in the images to those in the poses; 1 if it explains nothing."""
    pairs = [(_length(step.T_second_first), _length(_given(step))) for step in steps]
    if not all(seen > 0 and given > 0 for seen, given in pairs):
        return 1.0
    ratios = np.log([seen / given for seen, given in pairs])
    ratio = float(np.median(ratios))
    is_common = np.abs(ratios - ratio).max() <= SCALE_SPREAD * abs(ratio)
    if abs(ratio) <= np.log(MAX_SCALE) or not is_common:
        return 1.0
    scale = float(np.exp(ratio))
    # Lengths are uncertain where a rig hardly does more than turn.
    explained = _unexplained(steps, _given) - _unexplained(steps, _rescaled(scale))
    return scale if explained > SCALE_GAIN else 1.0


def _length(T: Array) -> float:
    return float(np.linalg.norm(T[:3, 3]))


def _are_seen(steps: Sequence[Step]) -> bool:
    """True if the images also support the motion of the poses.

    Repetitive patterns, such as bricks around a tower, look the same after several motions;
    tracking finds the shortest, unless it starts where the poses predict the corners.
    """
    led = [step_between(step.first, step.second, _given(step), step.num_corners) for step in steps]
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


def _readings(steps: Sequence[Step], scale: float) -> Iterator[tuple[str, float]]:
    """Other interpretations of the poses, and the share of motion each leaves unexplained."""
    turns = [pose(R, np.zeros(3)) for R in _right_angles()]
    for text, motion in (
        ("inverted, as they map the world to the camera", _inverse),
        ("in the opposite order", _backward),
        ("as those of a body whose axes are not the camera's", _given),
    ):
        shares = [_unexplained(steps, _turned(motion, T)) for T in turns]
        yield text, min(shares)
    if scale != 1.0:
        text = (
            f"with positions times {scale:.3g}: is their unit, the baseline or the focal length "
            "wrong?"
        )
        yield text, _unexplained(steps, _rescaled(scale))


def _turned(motion: Motion, T_body_camera: Array) -> Motion:
    """A motion of a body as that of its camera."""
    return lambda step: invert(T_body_camera) @ motion(step) @ T_body_camera


def _rescaled(scale: float) -> Motion:
    """The motion of the poses with other lengths."""

    def motion(step: Step) -> Array:
        T = _given(step)
        return pose(T[:3, :3], scale * T[:3, 3])

    return motion


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
