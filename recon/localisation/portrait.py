"""Portrait: the solids of a map with the colours that the pairs of its run show on them."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from recon.geometry import Array
from recon.localisation.backdrop import Backdrop
from recon.localisation.cameras import camera_of
from recon.localisation.contours import fitted
from recon.localisation.drawing import Solids, draw
from recon.localisation.paint import Paint
from recon.localisation.painting import Texels
from recon.localisation.revolved import ROUND, revolved
from recon.localisation.scales import FINER, scales, usual
from recon.records import FoundObject, StereoPair, as_rgb

SOLID_CELLS, OUTLINE_PX = 0.015, 0.1
"""Standard deviation of the place and size of a solid: of its shape, and of its outlines in the
images that show it best."""
PER_CELL = 2.5
"""Texels along the side of a cell, two levels above the finest."""


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
    side: Array
    """(S,) of a pixel on each solid, world units, in the images that show it best."""
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
        solids = fitted(rough, thing, _plain(*_shown(rough, pairs, 1)), pairs, cell_size)
        paint = _Painted.of(solids, pairs).paint
        solids = fitted(solids, thing, paint, pairs, cell_size, beside_only=True)
        painted = _Painted.of(solids, pairs)
        return cls(
            solids=solids,
            thing=thing,
            paint=painted.paint,
            plain=painted.plain,
            hoped=painted.hoped,
            side=painted.side,
            cell_size=cell_size,
            is_whole=len(np.unique(thing)) == len(objects)
            and len(round_ones) == sum(len(one.parts) for one in objects),
        )

    def of_thing(self, number: int) -> tuple[Solids, Paint]:
        """The solids of one object, and their mean colours."""
        rows = self.thing == number
        plain = self.plain._replace(grid=self.plain.grid[rows], first=self.plain.first[rows])
        return Solids(*(values[rows] for values in self.solids)), plain

    def centre(self, number: int) -> Array:
        """(3,) Middle of an object's solids."""
        middle: Array = self.solids.origin[self.thing == number].mean(axis=0)
        return middle

    def precision(self, number: int) -> float:
        """Standard deviation of the place and size of an object, world units."""
        outlines = OUTLINE_PX * float(self.side[self.thing == number].min())
        return math.hypot(SOLID_CELLS * self.cell_size, outlines)

    def size(self, number: int) -> float:
        """Radius of the largest solid of an object."""
        return float(self.solids.reach[self.thing == number].max())


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Painted:
    """Colours of solids by the pairs that show them."""

    paint: Paint
    plain: Paint
    hoped: Paint
    side: Array

    @classmethod
    def of(cls, solids: Solids, pairs: Sequence[StereoPair]) -> "_Painted":
        texels, backdrop = _shown(solids, pairs, 2**FINER)
        levels = [level for s in range(len(solids.origin)) for level in scales(*texels.of(s))]
        grid = np.array([level.sigma.shape for level in levels], np.int64)
        number, shape = grid.prod(axis=1), (len(solids.origin), -1)
        where = (grid.reshape(*shape, 2), (np.cumsum(number) - number).reshape(shape))
        mean = np.concatenate([level.mean.reshape(-1, 3) for level in levels]).astype(np.float32)
        sigma = np.concatenate([level.sigma.ravel() for level in levels]).astype(np.float32)
        clear = np.concatenate([level.is_clear.ravel() for level in levels])
        behind = (backdrop.log_density, backdrop.mean, backdrop.sigma)
        return cls(
            paint=Paint(*where, mean, sigma, *behind),
            plain=_plain(texels, backdrop),
            hoped=Paint(*where, mean, np.where(clear, sigma, np.float32(0.0)), *behind),
            side=np.array([_side(texels, solids, s) for s in range(len(solids.origin))]),
        )


def _shown(solids: Solids, pairs: Sequence[StereoPair], finer: int) -> tuple[Texels, Backdrop]:
    """Texels of solids, `finer` times as fine as their grids, and backdrop, as pairs show them."""
    texels, backdrop = Texels.blank(finer * solids.shape), Backdrop()
    for one in pairs:
        assert one.T_world_left is not None
        camera, image = camera_of(one.T_world_left, one.rig), as_rgb(one.left)
        drawn = draw(solids, camera, 1)
        backdrop.add(image, drawn, camera)
        texels.show(image, solids, drawn, camera)
    return texels, backdrop


def _side(texels: Texels, solids: Solids, s: int) -> float:
    """Median side of a pixel, world units, in the images that show a solid best."""
    width, _ = texels.of(s)
    seen = width[width > 0.0]
    along = float(np.ptp(solids.ends[s])) / width.shape[1]
    return along / float(np.median(seen)) if len(seen) else math.inf


def _plain(texels: Texels, backdrop: Backdrop) -> Paint:
    """The mean colour of each solid."""
    number = len(texels.grid)
    mean, sigma = zip(*(usual(*texels.of(s)) for s in range(number)), strict=True)
    return Paint(
        grid=np.ones((number, 1, 2), np.int64),
        first=np.arange(number)[:, None],
        mean=np.array(mean, np.float32),
        sigma=np.array(sigma, np.float32),
        backdrop=backdrop.log_density,
        behind=backdrop.mean,
        behind_sigma=backdrop.sigma,
    )
