"""Look: an image in several sizes, and how likely it is at poses in a portrait of the map."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from recon.camera import StereoRig
from recon.geometry import Array
from recon.localisation.cameras import camera_of
from recon.localisation.drawing import Drawn, Solids, draw
from recon.localisation.likelihood import LOG_ANY, bands, densities, values
from recon.localisation.paint import Paint
from recon.records import StereoPair, as_rgb

SKYLINE_PX = 2
"""Side of the pixels in which a backdrop is compared."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Look:
    """The left image of a pair."""

    pair: StereoPair
    _sizes: dict[int, Array] = field(default_factory=dict)

    @property
    def rig(self) -> StereoRig:
        """The rig of the pair."""
        return self.pair.rig

    def image(self, block: int) -> Array:
        """The image (R, C, 3), in means of blocks."""
        if block not in self._sizes:
            whole = as_rgb(self.pair.left)
            size = (whole.shape[1] // block, whole.shape[0] // block)
            cut = whole[: size[1] * block, : size[0] * block]
            smaller = cv2.resize(cut, size, interpolation=cv2.INTER_AREA)
            self._sizes[block] = smaller.astype(np.float64)
        return self._sizes[block]

    def values(self, solids: Solids, paint: Paint, poses: Sequence[Array], block: int) -> Array:
        """Log likelihoods (N,) of the whole image if taken there, by blocks of its pixels."""
        image, camera = self.image(block), camera_of(poses[0], self.rig)
        found: Array = block**2 * values(image, solids, paint, camera, np.array(poses))
        return found

    def explained(self, solids: Solids, paint: Paint, T_world_left: Array) -> tuple[int, int]:
        """Number of pixels that show a thing, at a pose, and of those that it explains."""
        drawn, here = self.densities(solids, paint, T_world_left, 1)
        shown = (drawn.solid >= 0) | (here < 0.0)
        return int(shown.sum()), int((here[shown] > 0.0).sum())

    def densities(
        self, solids: Solids, paint: Paint, T_world_left: Array, block: int
    ) -> tuple[Drawn, Array]:
        """The solids drawn at a pose, and the log density (R, C) of each block of the image."""
        camera = camera_of(T_world_left, self.rig)
        drawn = draw(solids, camera, block)
        return drawn, block**2 * densities(self.image(block), solids, drawn, paint, camera)

    def against(self, paint: Paint, pitch: float) -> tuple[float, int]:
        """Log likelihood if each pixel showed the backdrop or anything, and how many show that."""
        likely = paint.backdrop[self._bands(pitch), *self._levels()]
        num_other = SKYLINE_PX**2 * int((likely < LOG_ANY).sum())
        return SKYLINE_PX**2 * float(np.maximum(likely, LOG_ANY).sum()), num_other

    def _levels(self) -> NDArray[np.intp]:
        found: NDArray[np.intp] = np.moveaxis(self.image(SKYLINE_PX).astype(np.intp) >> 4, 2, 0)
        return found

    def _bands(self, pitch: float) -> NDArray[np.intp]:
        """Bands of elevation (R, C) of the pixels of a level camera that looks so far up."""
        v, u = np.indices(self.image(SKYLINE_PX).shape[:2])
        x = ((u + 0.5) * SKYLINE_PX - 0.5 - self.rig.cx_left_px) / self.rig.focal_px
        y = ((v + 0.5) * SKYLINE_PX - 0.5 - self.rig.cy_px) / self.rig.focal_px
        rise = math.sin(pitch) - math.cos(pitch) * y
        found: NDArray[np.intp] = bands(rise.ravel(), x.ravel(), y.ravel()).reshape(y.shape)
        return found
