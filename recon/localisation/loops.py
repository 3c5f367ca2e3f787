"""Loop closing: a drive that returns to known places is corrected as a whole.

Similar places are verified by the motion between them; Open3D's pose graph distributes the closing
errors along the path.
"""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation, Slerp

from recon.camera import StereoRig
from recon.geometry import invert, pose, without_drift
from recon.libraries import load_open3d
from recon.localisation.atlas import Atlas
from recon.sequences.odometry.motion import linearise
from recon.sequences.odometry.places import Meeting, meet

Array = NDArray[np.float64]

MIN_DETOUR = 4.0
"""A path back to a place is a loop if it is longer than the direct distance by this factor."""
DRIFT_SHARE = 0.1
"""Maximum drift of odometry, as a share of the path between two places."""
SAME_VIEW_COSINE = 0.5
NUM_CANDIDATES = 3
"""Number of most similar places that each place is compared with."""
MIN_AGREEING, MIN_AGREEING_SHARE = 24, 0.4
"""Minimum number, and share of the matched points, that agree on one motion."""
MAX_NODES = 300
"""Maximum number of nodes of the graph; poses between two nodes are interpolated."""
STEP_SHARE, STEP_DEG = 0.01, 0.1
"""Standard deviation of an odometry step: as a share of its length, and of its rotation."""
LOOP_SHARE, LOOP_DEG = 0.002, 0.05
"""The same for a loop, with the first as a share of the depth of its place: the least, to which the
uncertainty of its points is added."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Loop:
    """Two pairs of a drive that show the same place."""

    first: int
    second: int
    T_first_second: Array
    sigma: tuple[float, float]
    """Standard deviations of its shift, world units, and of its rotation, radians."""

    def error(self, poses: Array) -> float:
        """Closing error of poses (N, 4, 4)."""
        off = invert(poses[self.first]) @ poses[self.second]
        return float(np.linalg.norm(off[:3, 3] - self.T_first_second[:3, 3]))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Closed:
    """A drive after loop closing."""

    poses: Array
    """(N, 4, 4)"""
    num_loops: int
    error_before: float
    """Closing error of the surest loop before the correction, world units."""
    error_after: float


def close_loops(poses: Array, atlas: Atlas) -> Closed | None:
    """Correct the poses of a drive by its loops; None if it has none.

    Parameters
    ----------
    poses : (N, 4, 4) array
        Poses from odometry.
    atlas : Atlas
        Places of some of the pairs.
    """
    loops = find_loops(poses, atlas)
    if not loops:
        return None
    corrected = optimised(poses, loops)
    surest = min(loops, key=lambda loop: loop.sigma[0])
    return Closed(
        poses=corrected,
        num_loops=len(loops),
        error_before=surest.error(poses),
        error_after=surest.error(corrected),
    )


def find_loops(poses: Array, atlas: Atlas) -> list[Loop]:
    """The loops of a drive: pairs of places that show the same."""
    if len(atlas) < 2:
        return []
    steps = np.linalg.norm(np.diff(poses[:, :3, 3], axis=0), axis=1)
    way = np.append(0.0, np.cumsum(steps))[atlas.numbers]
    at, ahead = atlas.T_world_left[:, :3, 3], atlas.T_world_left[:, :3, 2]
    summaries, depths = atlas.summaries, atlas.depths
    loops = []
    for row in range(1, len(atlas)):
        detour = way[row] - way[:row]
        apart = np.linalg.norm(at[:row] - at[row], axis=1)
        is_near = (apart < DRIFT_SHARE * detour + depths[row]) & (
            detour > MIN_DETOUR * np.maximum(depths[row], apart - DRIFT_SHARE * detour)
        )
        earlier = np.flatnonzero(is_near & (ahead[:row] @ ahead[row] > SAME_VIEW_COSINE))
        likeness = summaries[earlier] @ summaries[row]
        for other in earlier[np.argsort(-likeness, kind="stable")[:NUM_CANDIDATES]]:
            loop = _loop(atlas, int(other), row)
            if loop is not None:
                loops.append(loop)
    return loops


def _loop(atlas: Atlas, first: int, second: int) -> Loop | None:
    met = meet(atlas.places[first], atlas.places[second])
    if met is None or met.num_agreeing < MIN_AGREEING or met.share < MIN_AGREEING_SHARE:
        return None
    place = atlas.places[second]
    turn, shift = spread_of(met, place.rig)
    return Loop(
        first=atlas.numbers[first],
        second=atlas.numbers[second],
        T_first_second=invert(met.T_second_first),
        sigma=(
            float(np.hypot(shift, LOOP_SHARE * place.depth)),
            float(np.hypot(turn, np.radians(LOOP_DEG))),
        ),
    )


def spread_of(met: Meeting, rig: StereoRig) -> tuple[float, float]:
    """Largest standard deviations of the rotation (radians) and the shift between two places."""
    at = linearise(met.T_second_first, met.tracks, rig)
    covariance = np.linalg.pinv(at.normal_equations()[0]) * at.spread**2
    turn, shift = (
        np.linalg.eigvalsh(part)[-1] for part in (covariance[:3, :3], covariance[3:, 3:])
    )
    return float(np.sqrt(turn)), float(np.sqrt(shift))


def optimised(poses: Array, loops: Sequence[Loop]) -> Array:
    """The poses (N, 4, 4) that agree best with the steps between them and the loops."""
    nodes = _nodes(len(poses), loops)
    graph = _graph(poses, nodes, loops)
    registration = load_open3d().pipelines.registration
    registration.global_optimization(
        graph,
        registration.GlobalOptimizationLevenbergMarquardt(),
        registration.GlobalOptimizationConvergenceCriteria(),
        registration.GlobalOptimizationOption(reference_node=0),
    )
    found = np.array([without_drift(node.pose) for node in graph.nodes])
    # The first pose stays.
    return _carried(poses, nodes, poses[0] @ invert(found[0]) @ found)


def _nodes(number: int, loops: Sequence[Loop]) -> NDArray[np.intp]:
    """Indices of the poses that become nodes: evenly spaced ones and the ends of loops."""
    spaced = np.linspace(0, number - 1, min(number, MAX_NODES)).astype(np.intp)
    kept = loops[:: 1 + len(loops) // MAX_NODES]
    ends = [end for loop in kept for end in (loop.first, loop.second)]
    return np.union1d(spaced, np.array(ends, np.intp))


def _graph(poses: Array, nodes: NDArray[np.intp], loops: Sequence[Loop]) -> Any:
    registration = load_open3d().pipelines.registration
    graph = registration.PoseGraph()
    row = {int(number): at for at, number in enumerate(nodes)}
    for number in nodes:
        graph.nodes.append(registration.PoseGraphNode(poses[number]))
    for first, second in itertools.pairwise(nodes):
        T_first_second = invert(poses[first]) @ poses[second]
        length = float(np.linalg.norm(T_first_second[:3, 3]))
        sigma = STEP_SHARE * length, np.radians(STEP_DEG) * np.sqrt(second - first)
        graph.edges.append(_edge(row[int(second)], row[int(first)], T_first_second, sigma))
    for loop in loops:
        if loop.first in row and loop.second in row:
            ends = row[loop.second], row[loop.first]
            graph.edges.append(_edge(*ends, loop.T_first_second, loop.sigma))
    return graph


def _edge(source: int, target: int, T_target_source: Array, sigma: tuple[float, float]) -> Any:
    shift, turn = max(sigma[0], 1e-6), sigma[1]
    information = np.diag(np.repeat([turn**-2.0, shift**-2.0], 3))
    return load_open3d().pipelines.registration.PoseGraphEdge(
        source, target, T_target_source, information, uncertain=False
    )


def _carried(poses: Array, nodes: NDArray[np.intp], found: Array) -> Array:
    """All poses, interpolated between the corrections of the neighbouring nodes."""
    corrected = poses.copy()
    corrected[nodes] = found
    for at, (first, second) in enumerate(itertools.pairwise(nodes)):
        T_first = found[at] @ invert(poses[first])
        T_second = found[at + 1] @ invert(poses[second])
        for number in range(first + 1, second):
            share = (number - first) / (second - first)
            here = poses[number]
            corrected[number] = _between(T_first @ here, T_second @ here, share)
    return corrected


def _between(first: Array, second: Array, share: float) -> Array:
    turns = Rotation.from_matrix(np.stack([first[:3, :3], second[:3, :3]]))
    position = (1.0 - share) * first[:3, 3] + share * second[:3, 3]
    return pose(Slerp([0.0, 1.0], turns)(share).as_matrix(), position)
