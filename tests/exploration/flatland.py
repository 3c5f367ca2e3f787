"""A world of upright cylinders and a simulated stereo, for exploration without images."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from recon.camera import StereoRig
from recon.geometry import look_at
from recon.mapping.pair import PairResult
from recon.records import Matches, PointCloud, StereoPair, View
from recon.settings import Settings, updated
from recon.world.objects import TrueObject

HEIGHT = 5.0
FOCAL_PX = 152.55
LENGTHS = {
    "map": ("cell_size",),
    "eyes": ("baseline", "near", "far", "eye_height"),
    "exploration": ("clearance", "walk_clearance", "sight_range", "viewing_distance"),
    "world": ("size_x", "size_z", "height"),
    "recognition": ("ground_clearance",),
    "motion": ("body_radius", "body_height", "position_noise"),
    "render": ("texture_tile",),
}
"""Every setting that is a length, by stage."""


def in_units(settings, scale):
    """Scale every length in the settings."""
    return updated(
        settings,
        {
            stage: {
                name: scale * length
                for name in names
                # Values that are None follow from the scaled lengths.
                if (length := getattr(getattr(settings, stage), name)) is not None
            }
            for stage, names in LENGTHS.items()
        },
    )


@dataclass
class Flatland:
    """Cylinders (x, z, radius, height) on a floor, with the interface of an explorable world."""

    discs: Sequence[tuple[float, float, float, float]]
    settings: Settings
    sigma_px: float = 0.1
    glass: Sequence[tuple[float, float, float, float]] = ()
    """Cylinders that no camera sees."""
    objects: tuple[TrueObject, ...] = field(init=False)

    def __post_init__(self):
        self.objects = tuple(
            TrueObject(
                id=i,
                label="unknown",
                centre=np.array([x, height / 2, z]),
                size=np.array([2 * radius, height, 2 * radius]),
                visuals=(i,),
            )
            for i, (x, z, radius, height) in enumerate(self.discs)
        )

    def start(self):
        height = self.settings.eyes.eye_height
        return View(
            position=np.array([0, height, 0.0]), target=np.array([0, height, -2.0 * height])
        )

    def take(self, view):
        baseline = self.settings.eyes.baseline
        D = np.linalg.norm(view.target - view.position)
        shift = FOCAL_PX * baseline / D / 2
        rig = StereoRig(
            width=256, height=256, focal_px=FOCAL_PX, cx_left_px=127.5 - shift,
            cx_right_px=127.5 + shift, cy_px=127.5, baseline=baseline,
        )  # fmt: skip
        T = look_at(view.position, view.target)
        T[:3, 3] -= baseline / 2 * T[:3, 0]
        blank = np.zeros((256, 256), dtype=np.uint8)
        return StereoPair(left=blank, right=blank, rig=rig, T_world_left=T)

    def body_clearance(self, places_xz, height):
        places = np.asarray(places_xz)
        nearest = np.full(len(places), np.inf)
        for x, z, radius, top in [*self.discs, *self.glass]:
            assert top >= height, "lower than the body, which this world does not measure"
            nearest = np.minimum(nearest, np.abs(np.hypot(*(places - (x, z)).T) - radius))
        return nearest

    def is_inside(self, positions):
        positions = np.asarray(positions)
        inside = np.zeros(len(positions), dtype=bool)
        for x, z, radius, height in self.discs:
            side = np.hypot(positions[:, 0] - x, positions[:, 2] - z)
            inside |= (side < radius) & (positions[:, 1] < height)
        return inside

    def free_ground(self, cell_size):
        sizes = [self.settings.world.size_x, self.settings.world.size_z]
        shape = [int(np.ceil(n / cell_size - 1e-9)) for n in sizes]
        x, z = (
            (np.arange(n) + 0.5) * cell_size - size / 2
            for n, size in zip(shape, sizes, strict=True)
        )
        free = np.ones(shape, dtype=bool)
        for cx, cz, radius, _ in self.discs:
            free &= np.hypot(x[:, None] - cx, z - cz) > radius
        return free

    def match_points(self, pair, settings):
        """Replace `recon.mapping.pair.match_points` by random visible points."""
        rng = np.random.default_rng(int(pair.stamp_s))
        points, depth = self._visible(pair, rng)
        sigma = pair.rig.depth_sigma(depth, self.sigma_px)
        eye = pair.T_world_left[:3, 3]
        noisy = points + (points - eye) * (rng.normal(0, sigma) / depth)[:, None]
        cloud = PointCloud(
            points=noisy, colours=np.full((len(noisy), 3), 90, dtype=np.uint8), sigma=sigma
        )
        return replace(nothing(), cloud=cloud)

    def _visible(self, pair, rng):
        """Select a tenth of the left pixels as edges, with their world points."""
        u, v = rng.uniform(0, 255, (2, 6500))
        rays = pair.rig.rays(np.column_stack([u, v])) @ pair.T_world_left[:3, :3].T
        eye = pair.T_world_left[:3, 3]
        depth = np.full(len(rays), np.inf)
        for disc in self.discs:
            depth = np.minimum(depth, _hit(eye, rays, disc))
        eyes = self.settings.eyes
        seen = (depth > 22.0 * eyes.near) & (depth < eyes.far)
        return eye + depth[seen, None] * rays[seen], depth[seen]


def _hit(eye, rays, disc):
    """Compute the depth at which rays of unit depth hit the side of a cylinder."""
    x, z, radius, height = disc
    a = rays[:, 0] ** 2 + rays[:, 2] ** 2
    ox, oz = eye[0] - x, eye[2] - z
    b = rays[:, 0] * ox + rays[:, 2] * oz
    c = ox * ox + oz * oz - radius * radius
    root = b * b - a * c
    t = (-b - np.sqrt(np.maximum(root, 0))) / a
    y = eye[1] + t * rays[:, 1]
    return np.where((root > 0) & (t > 0) & (y > 0) & (y < height), t, np.inf)


def nothing():
    """Give the result of a pair that shows nothing."""
    none = PointCloud(
        points=np.empty((0, 3)), colours=np.empty((0, 3), dtype=np.uint8), sigma=np.empty(0)
    )
    return PairResult(matches=no_matches(), cloud=none, doubtful=none, image_noise=(0.0, 0.0))


def no_matches():
    none = np.empty(0)
    return Matches(
        points_px=np.empty((0, 2)), disparity_px=none, sigma_px=none, score=none,
        index_left=np.empty(0, dtype=np.int32), index_right=np.empty(0, dtype=np.int32),
    )  # fmt: skip
