"""Loops: a drive that comes back to places that it knows is corrected as a whole.

Places that look alike are checked by the motion between them; Open3D's pose graph distributes what
is left over at each closing along the way.
"""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation, Slerp

from recon.geometry import invert, pose, without_drift
from recon.libraries import load_open3d
from recon.localisation.atlas import Atlas
from recon.sequences.odometry.places import meet

Array = NDArray[np.float64]

MIN_DETOUR = 4.0
"""A way back is a loop where it is so many times as long as the way straight there."""
DRIFT_SHARE = 0.1
"""Of the way between two places, that odometry may be off at most."""
SAME_VIEW_COSINE = 0.5
NUM_CANDIDATES = 3
"""Places that look most alike, which are held against each place."""
MIN_AGREEING, MIN_AGREEING_SHARE = 24, 0.4
"""Points, and share of those that look alike, that have to agree on one motion."""
MAX_NODES = 300
"""Of the graph; what lies between two of them is carried along."""
STEP_SHARE, STEP_DEG = 0.01, 0.1
"""Standard deviation of a step of odometry: of its length, and of its turn."""
LOOP_SHARE, LOOP_DEG = 0.002, 0.05
"""The same of a loop, as a share of the depth of its place."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Loop:
    """Two pairs of a drive that show the same place."""

    first: int
    second: int
    T_first_second: Array
    depth: float
    """Median depth of the place, world units."""

    def error(self, poses: Array) -> float:
        """Distance by which poses (N, 4, 4) miss the closing."""
        off = invert(poses[self.first]) @ poses[self.second]
        return float(np.linalg.norm(off[:3, 3] - self.T_first_second[:3, 3]))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Closed:
    """A drive after its loops are closed."""

    poses: Array
    """(N, 4, 4)"""
    num_loops: int
    error_before: float
    """Greatest distance by which a loop was missed, world units."""
    error_after: float


def close_loops(poses: Array, atlas: Atlas) -> Closed | None:
    """Correct the poses of a drive by its loops; None if it has none.

    Parameters
    ----------
    poses : (N, 4, 4) array
        By odometry.
    atlas : Atlas
        Places of some of the pairs.
    """
    loops = find_loops(poses, atlas)
    if not loops:
        return None
    corrected = optimised(poses, loops)
    return Closed(
        poses=corrected,
        num_loops=len(loops),
        error_before=max(loop.error(poses) for loop in loops),
        error_after=max(loop.error(corrected) for loop in loops),
    )


def find_loops(poses: Array, atlas: Atlas) -> list[Loop]:
    """The places of a drive that it comes back to."""
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
    return Loop(
        first=atlas.numbers[first],
        second=atlas.numbers[second],
        T_first_second=invert(met.T_second_first),
        depth=atlas.places[second].depth,
    )


def optimised(poses: Array, loops: Sequence[Loop]) -> Array:
    """The poses (N, 4, 4) that agree best with the steps between them and with the loops."""
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
    # The first pose is where it was.
    return _carried(poses, nodes, poses[0] @ invert(found[0]) @ found)


def _nodes(number: int, loops: Sequence[Loop]) -> NDArray[np.intp]:
    """Numbers of the poses that become nodes: evenly spaced, and the ends of loops."""
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
            sigma = LOOP_SHARE * loop.depth, np.radians(LOOP_DEG)
            ends = row[loop.second], row[loop.first]
            graph.edges.append(_edge(*ends, loop.T_first_second, sigma))
    return graph


def _edge(source: int, target: int, T_target_source: Array, sigma: tuple[float, float]) -> Any:
    shift, turn = max(sigma[0], 1e-6), sigma[1]
    information = np.diag(np.repeat([turn**-2.0, shift**-2.0], 3))
    return load_open3d().pipelines.registration.PoseGraphEdge(
        source, target, T_target_source, information, uncertain=False
    )


def _carried(poses: Array, nodes: NDArray[np.intp], found: Array) -> Array:
    """All poses, moved with the nodes before and after them."""
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
