"""Synthetic depth maps of a ball and a wall, exact except for the requested noise."""

import numpy as np

from recon.camera import StereoRig
from recon.surface.assembly import Assembly
from recon.surface.depth import DepthMap

WIDTH, HEIGHT = 96, 80
RIG = StereoRig(
    width=WIDTH, height=HEIGHT, focal_px=90.0, cx_left_px=47.5, cx_right_px=47.5, cy_px=39.5,
    baseline=0.2,
)  # fmt: skip
DISTANCE, RADIUS = 4.0, 1.0
COLOUR = (200, 100, 50)
VOXEL = 0.08


def pose_at(angle_deg):
    """Place a camera on a circle around the origin, looking at it; y is up in the world."""
    angle = np.deg2rad(angle_deg)
    position = DISTANCE * np.array([np.sin(angle), 0.0, np.cos(angle)])
    ahead, down = -position / DISTANCE, np.array([0.0, -1.0, 0.0])
    T = np.eye(4)
    T[:3, :3] = np.stack([np.cross(down, ahead), down, ahead], axis=1)
    T[:3, 3] = position
    return T


def view_of(depth, T, sigma, noise=0.0, seed=0):
    noisy = depth + noise * np.random.default_rng(seed).normal(size=depth.shape)
    return DepthMap(
        depth=noisy.astype(np.float32),
        sigma=np.full(depth.shape, sigma, np.float32),
        colours=np.full((*depth.shape, 3), COLOUR, np.uint8),
        rig=RIG,
        T_world_left=T,
    )


def ball_view(angle_deg, noise=0.0, sigma=0.01):
    """Render a ball of radius 1 around the origin."""
    T = pose_at(angle_deg)
    v, u = np.mgrid[:HEIGHT, :WIDTH]
    rays = RIG.rays(np.column_stack([u.ravel(), v.ravel()])) @ T[:3, :3].T
    a, b = (rays**2).sum(axis=1), rays @ T[:3, 3]
    root = b * b - a * (DISTANCE**2 - RADIUS**2)
    depth = np.where(root > 0, (-b - np.sqrt(np.maximum(root, 0))) / a, np.nan)
    return view_of(depth.reshape(HEIGHT, WIDTH), T, sigma, noise, int(angle_deg))


def wall_view(distance=4.0, sigma=0.01, x=0.0):
    """Render a wall facing a camera at (x, 0, 0) that looks along z."""
    T = np.eye(4)
    T[0, 3] = x
    return view_of(np.full((HEIGHT, WIDTH), distance), T, sigma)


def mesh_of(volume, folder=None):
    """Extract the whole surface of a volume, including floaters, in grey."""
    assembly = Assembly(0.0, folder)
    for region in volume.regions():
        assembly.add(region, np.full(region.vertices.shape, 128, np.uint8))
    return assembly.finish().whole
