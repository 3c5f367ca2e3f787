"""A small rendered recording shared by tests of several folders."""

from pathlib import Path

import numpy as np

from recon.cli import main
from recon.exports.ply import write_mesh
from recon.records import Mesh

SIZE = ["--set", "eyes.width=120", "--set", "eyes.height=96", "--set", "eyes.fov_deg=40"]
RIG = ["--set", "eyes.baseline=0.4", "--set", "render.noise=1.5"]


def contents(folder: Path) -> dict[str, bytes]:
    """The bytes of every file in a folder, by name."""
    return {one.name: one.read_bytes() for one in folder.iterdir()}


def write_wall(path: Path) -> None:
    """Write a mesh of a wall of many colours, a grid of small squares."""
    side = 24
    v, u = np.mgrid[: side + 1, : side + 1]
    vertices = np.stack([u.ravel() / 8 - 1.5, v.ravel() / 8, 0.0 * u.ravel()], axis=1)
    a = (v[:-1, :-1] * (side + 1) + u[:-1, :-1]).ravel()
    across, along = a + 1, a + side + 1
    opposite = along + 1
    halves = [(a, across, opposite), (a, opposite, along)]
    triangles = np.concatenate([np.stack(half, axis=1) for half in halves]).astype(np.int32)
    colours = np.random.default_rng(4).integers(30, 226, (len(vertices), 3)).astype(np.uint8)
    write_mesh(path, Mesh(vertices=vertices, triangles=triangles, colours=colours))


def render_drive(folder: Path, num_views: int, size: list[str] = SIZE) -> Path:
    """Render views along the wall; return the folder of the recording."""
    write_wall(folder / "wall.ply")
    views = ["--views", f"drive:{num_views}"]
    drive = folder / "drive"
    assert main(["render", str(folder / "wall.ply"), *views, *size, *RIG, "-o", str(drive)]) == 0
    return drive
