"""Portrait: the solids of a map with the colours that the pairs of its run show on them."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from recon.geometry import Array
from recon.localisation.cameras import camera_of
from recon.localisation.contours import fitted
from recon.localisation.drawing import (
    LEVELS,
    LOG_ANY,
    NUM_BANDS,
    Camera,
    Drawn,
    Paint,
    Solids,
    bands,
    draw,
)
from recon.localisation.repeats import completed
from recon.localisation.revolved import ROUND, revolved, texels
from recon.records import FoundObject, StereoPair, as_rgb

PER_CELL = 3.5
"""Texels along the side of a cell."""
LEAST_COSINE = 0.2
"""Of the angle between the line of sight and the normal: at outlines colours are mixed."""
MARGIN_PX = 2
HIDDEN_CELLS, HIDDEN_SHARE = 0.3, 0.02
"""Tolerance of depths in what hides a texel: in cells, and as a share of its depth."""
FINE_PX = 0.6
"""Least width of a texel, foreshortened, in an image that shows its colour."""
CLEAR_PX = 2.0
"""Least width of a texel in an image that shows the texture as it is."""
COLOUR_SIGMA = 14.0
"""Standard deviation of a channel of the same texel seen twice."""
BACKDROP_SHARE = 0.95
"""Share of the pixels behind everything that have colours seen there before."""
BLURS_PX = (1, 2, 3, 5, 9)
"""Widths of the means that a texel's colour is read from, as wide as the texel."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Portrait:
    """Solids with their colours, and the colours behind them."""

    solids: Solids
    thing: NDArray[np.intp]
    """(S,) number of each solid's object."""
    paint: Paint
    plain: Paint
    """The same with the mean colour of each solid: all sides look alike."""
    hoped: Paint
    """The same if sides that no pair has shown clearly agree as well as others."""
    cell_size: float
    is_whole: bool
    """True if all parts of all objects are drawn."""

    @classmethod
    def of(
        cls, objects: Sequence[FoundObject], pairs: Sequence[StereoPair], cell_size: float
    ) -> "Portrait | None":
        """The portrait of objects by the pairs of a run; None if none of them is round."""
        round_ones = [
            (part.solid, number)
            for number, one in enumerate(objects)
            for part in one.parts
            if isinstance(part.solid, ROUND) and one.holds(part.solid)
        ]
        if not round_ones:
            return None
        thing = np.array([number for _, number in round_ones], np.intp)
        rough = revolved([solid for solid, _ in round_ones], cell_size / PER_CELL)
        plain = _Painted.of(rough, pairs, cell_size).plain
        solids = fitted(rough, thing, plain, pairs, cell_size)
        painted = _Painted.of(solids, pairs, cell_size)
        return cls(
            solids=solids,
            thing=thing,
            paint=painted.paint,
            plain=painted.plain,
            hoped=painted.hoped,
            cell_size=cell_size,
            is_whole=len(np.unique(thing)) == len(objects)
            and len(round_ones) == sum(len(one.parts) for one in objects),
        )

    def of_thing(self, number: int) -> Solids:
        """The solids of one object."""
        rows = self.thing == number
        return Solids(*(values[rows] for values in self.solids))

    def centre(self, number: int) -> Array:
        """(3,) Middle of an object's solids."""
        middle: Array = self.solids.origin[self.thing == number].mean(axis=0)
        return middle

    def size(self, number: int) -> float:
        """Radius of the largest solid of an object."""
        return float(self.solids.reach[self.thing == number].max())


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Painted:
    """Colours of solids by the pairs that show them."""

    paint: Paint
    plain: Paint
    hoped: Paint

    @classmethod
    def of(cls, solids: Solids, pairs: Sequence[StereoPair], cell_size: float) -> "_Painted":
        points, normals = (np.concatenate(both) for both in zip(*texels(solids), strict=True))
        width, colours = np.zeros(len(points)), np.zeros((len(points), 3))
        backdrop = np.zeros((NUM_BANDS, LEVELS, LEVELS, LEVELS))
        for one in pairs:
            assert one.T_world_left is not None
            camera, image = camera_of(one.T_world_left, one.rig), as_rgb(one.left)
            drawn = draw(solids, camera, 1)
            _count(backdrop, image, drawn, camera)
            rows, here_px, wide = _shown(points, normals, drawn, camera, cell_size)
            better = wide > width[rows]
            rows = rows[better]
            width[rows] = wide[better]
            colours[rows] = _read(image, here_px[better], wide[better])
        return cls._by(solids, width, colours, _log_density(backdrop))

    @classmethod
    def _by(cls, solids: Solids, width: Array, colours: Array, backdrop: Array) -> "_Painted":
        """Colours where pairs showed them finely enough, else those of the whole solid."""
        usual, spread = np.full(colours.shape, 128.0), np.full(len(colours), 80.0)
        mean, known = colours.copy(), width > FINE_PX
        for start, (around, along) in zip(solids.start, solids.shape, strict=True):
            rows = slice(start, start + around * along)
            of = colours[rows][known[rows]]
            if len(of):
                usual[rows] = of.mean(axis=0)
                spread[rows] = np.hypot(math.sqrt(of.var(axis=0).mean()), COLOUR_SIGMA)
            grid, is_known = completed(
                colours[rows].reshape(around, along, 3), known[rows].reshape(around, along)
            )
            mean[rows], known[rows] = grid.reshape(-1, 3), is_known.ravel()
        # A texel about as wide as a pixel has some colour of those around it.
        vague = spread * np.clip(1.5 - np.where(width > FINE_PX, width, 1.0), 0.0, 1.0)
        mean, sigma = np.where(known[:, None], mean, usual), np.hypot(COLOUR_SIGMA, vague)
        return cls(
            paint=Paint(mean=mean, sigma=np.where(known, sigma, spread), backdrop=backdrop),
            plain=Paint(mean=usual, sigma=spread, backdrop=backdrop),
            hoped=Paint(mean=mean, sigma=np.where(width > CLEAR_PX, sigma, 0.0), backdrop=backdrop),
        )


def _shown(
    points: Array, normals: Array, drawn: Drawn, camera: Camera, cell_size: float
) -> tuple[NDArray[np.intp], Array, Array]:
    """Rows (M,) of the texels that a pair shows, where (M, 2), and how wide they are in pixels."""
    offset = points - camera.eye
    local = offset @ camera.turn
    cosine = -np.einsum("ni,ni->n", offset, normals) / np.linalg.norm(offset, axis=1)
    rows = np.flatnonzero((cosine > LEAST_COSINE) & (local[:, 2] > HIDDEN_CELLS * cell_size))
    depth = local[rows, 2]
    here_px = camera.focal_px * local[rows, :2] / depth[:, None] + [camera.cx_px, camera.cy_px]
    last = np.array([camera.width, camera.height]) - 1 - MARGIN_PX
    inside = ((here_px >= MARGIN_PX) & (here_px <= last)).all(axis=1)
    rows, here_px, depth = rows[inside], here_px[inside], depth[inside]
    column, row = np.rint(here_px).astype(np.intp).T
    # Not beside an outline, where colours are mixed with those behind it.
    inner = cv2.erode(np.isfinite(drawn.depth).astype(np.uint8), np.ones((3, 3), np.uint8))
    slack = HIDDEN_CELLS * cell_size + HIDDEN_SHARE * depth
    clear = (inner[row, column] > 0) & (np.abs(drawn.depth[row, column] - depth) < slack)
    wide = camera.focal_px / depth * cosine[rows] * cell_size / PER_CELL
    return rows[clear], here_px[clear], wide[clear]


def _read(image: NDArray[np.uint8], points_px: Array, width: Array) -> Array:
    """Colours (N, 3) at points (N, 2), means over about so many pixels (N,)."""
    colours = np.zeros((len(points_px), 3))
    nearest = np.abs(np.log(np.maximum(width, 1.0))[:, None] - np.log(BLURS_PX)).argmin(axis=1)
    for number, blur_px in enumerate(BLURS_PX):
        rows = np.flatnonzero(nearest == number)
        if len(rows):
            u, v = points_px[rows].astype(np.float32).T[:, None]
            blurred = cv2.blur(image, (blur_px, blur_px))
            colours[rows] = cv2.remap(blurred, u, v, cv2.INTER_LINEAR)[0]
    return colours


def _count(backdrop: Array, image: NDArray[np.uint8], drawn: Drawn, camera: Camera) -> None:
    """Count the colours of an image where nothing is drawn, by their elevation."""
    row, column = np.nonzero(drawn.texel < 0)
    x, y = (column - camera.cx_px) / camera.focal_px, (row - camera.cy_px) / camera.focal_px
    rise = bands(camera.turn[1, 0] * x + camera.turn[1, 1] * y + camera.turn[1, 2], x, y)
    red, green, blue = (image[row, column] >> 4).astype(np.intp).T
    np.add.at(backdrop, (rise, red, green, blue), 1.0)


def _log_density(counts: Array) -> Array:
    """Log density of colours by their numbers; any colour may occur."""
    total = np.maximum(counts.sum(axis=(1, 2, 3), keepdims=True), 1.0)
    seen = BACKDROP_SHARE * counts / total * (LEVELS / 256.0) ** 3
    density: Array = np.log(seen + (1.0 - BACKDROP_SHARE) * math.exp(LOG_ANY))
    return density
