"""Images of the whole world from above and from the front."""

import numpy as np

from recon.errors import InputError
from recon.geometry import Array
from recon.settings.world import WorldSettings
from recon.world.render import Camera


def top_camera(floor: WorldSettings, size: int) -> Camera:
    """The camera that looks down on the floor: x right, z down, the longer side `size` pixels."""
    return _parallel_camera(
        shape_units=(floor.size_x, floor.size_z),
        unit=_pixel_side(max(floor.size_x, floor.size_z), size),
        corner=np.array([-floor.size_x / 2, floor.height, -floor.size_z / 2]),
        axes=np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]),
        far=2.0 * floor.height,
    )


def front_camera(floor: WorldSettings, size: int) -> Camera:
    """The camera that looks along -z at the floor's front: x right over `size` pixels, y up."""
    return _parallel_camera(
        shape_units=(floor.size_x, floor.height),
        unit=_pixel_side(floor.size_x, size),
        corner=np.array([-floor.size_x / 2, floor.height, floor.size_z / 2]),
        axes=np.array([[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]]),
        far=floor.size_z,
    )


def _pixel_side(length: float, size: int) -> float:
    if size < 1:
        raise InputError(f"size is {size} pixels, but at least 1 is needed")
    return length / size


def _parallel_camera(
    shape_units: tuple[float, float], unit: float, corner: Array, axes: Array, far: float
) -> Camera:
    """Parallel rays from the rectangle at `corner`; axes are right, down and forward."""
    right, down, forward = axes
    width, height = (max(1, round(length / unit)) for length in shape_units)
    return Camera(
        width=width,
        height=height,
        near=0.0,
        far=far,
        frame=np.array(
            [
                corner + 0.5 * unit * (right + down),
                forward,
                unit * right,
                np.zeros(3),
                unit * down,
                np.zeros(3),
            ]
        ),
    )
