"""The probability that an object is of its kind, complete and sufficiently visible.

Each condition has its own logistic, and all are multiplied, so that nothing compensates for a
condition that is not met. The numbers started as a maximum likelihood fit to 440 simulated objects,
half of them of no kind, partly visible and noisy, and to components of recorded maps, with equal
total weight; they were then chosen by hand among a few combinations that avoid false names in
recorded maps. The one for hardly visible surfaces is set by principle.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Logistic:
    """A condition that holds with probability one half at `middle`, more above it."""

    middle: float
    steepness: float

    def chance(self, value: Array | float) -> Array:
        """Probability at each value."""
        exponent = self.steepness * (np.asarray(value, dtype=np.float64) - self.middle)
        chances: Array = 1.0 / (1.0 + np.exp(-np.clip(exponent, -60.0, 60.0)))
        return chances


FORM = Logistic(middle=0.7, steepness=7.0)
"""Deviance per cell below that of a formless object: the fit must be meaningful. Simulated objects
have 1.3 and more, even where noise is wider than a cell; a vase and rocks of few cells 0.9."""
LEAD = Logistic(middle=0.3, steepness=7.0)
"""Deviance per cell below that of the best single solid: a box is not a tree only because a tree
fits it."""
LOWEST = Logistic(middle=float(np.log(3.0)), steepness=4.0)
"""The same of the lowest part, of which less is needed: a trunk is thin and partly hidden, but one
that no cell shows is none. Simulated objects have 12 and more, one in a hundred 4."""
STRAIGHT = Logistic(middle=-0.1, steepness=60.0)
"""BIC per cell by which the outlines of parts explain their cells better than curves of the height
do: of simulated objects -0.06 and more, of most urns and wells -0.1 and less."""
OTHER_SHAPES = Logistic(middle=-0.19, steepness=40.0)
"""Lead of parts on one axis over parts of other shapes: what a post with a ball explains better is
no cottage, although it has no name. Simulated trees, cottages and lamps have 0 and more, one in 700
-0.12; hydrants and the legs of an arch -0.22 and less."""
SEEN = Logistic(middle=float(np.log(0.03)), steepness=2.5)
"""Log of the visible share of a part's surface."""
RESOLVED = Logistic(middle=float(np.log(0.6)), steepness=4.0)
"""Log of the minimum width of a part in cells."""

ORDERED = Logistic(middle=-0.9, steepness=4.0)
"""Lead of an assembly; the arrangement of its parts is stronger evidence than the distances of
cells."""
ENOUGH = Logistic(middle=float(np.log(25.0)), steepness=4.0)
"""Log of the number of cells: a handful fits anything."""
MANY = Logistic(middle=float(np.log(40.0)), steepness=4.0)
"""The same of an assembly, which has more parts that a few cells may be. Simulated ones have 65 at
least."""
ABOVE = Logistic(middle=float(np.log(8.0)), steepness=4.0)
"""Log of the number of cells of each part above the lowest: any few cells fit a crown. Simulated
objects have 11 at least."""
EXPLAINED = Logistic(middle=0.75, steepness=20.0)
"""Share of the cells on the parts of an assembly: of simulated ones 0.85 and more, one in a hundred
0.77."""
SHOWN = Logistic(middle=float(np.log(12.0)), steepness=4.0)
"""Log of the number of cells of a plane that an assembly needs: any few cells fit one."""
SQUARE = Logistic(middle=0.65, steepness=20.0)
"""Squareness of walls: of simulated houses 0.86 at least, of rocks 0.4 at most."""
FREE = Logistic(middle=0.25, steepness=25.0)
"""Share of a board below which there is air: of simulated tables and benches 0.4 at least, of
level slices of walls and fences 0.2 at most."""
ROOF = Logistic(middle=0.4, steepness=40.0)
"""Share of its walls' extent along which a roof extends: of simulated houses 0.45 at least, one in
fifty 0.58; of slopes on the corner of a recorded box 0.17 and 0.37."""
BACK = Logistic(middle=0.65, steepness=40.0)
"""Share of its seat's extent along which a back extends: of simulated benches 0.75 at least, of an
edge of a recorded floor 0.56."""
UNPIERCED = Logistic(middle=-0.12, steepness=60.0)
"""Share by which a back pierces its seat, negated: of simulated benches -0.09 at least, of planes
across a recorded motorcycle -0.11 to -0.16."""
FORMED = Logistic(middle=-0.5, steepness=6.0)
"""Lead of parts of revolution over planes, and of upright planes over parts of revolution: either
fits anything a little."""
FLAT = Logistic(middle=-0.3, steepness=20.0)
"""BIC per cell by which upright planes explain their cells better than curved surfaces: walls of
simulated houses and benches have -0.2 and more, rocks and cylinders -0.4 and less."""
FILLED = Logistic(middle=0.55, steepness=25.0)
"""Share of the faces of a box that cells fill, of those that are seen at all."""
NEARNESS = Logistic(middle=0.0, steepness=6.0)
"""Log of the distance to a learned kind's examples, below its threshold."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Evidence:
    """Evidence for a fit, independent of its kind."""

    criterion: float
    """BIC per cell, minus that of a formless object."""
    lead: float
    """Lead over the best rival of no kind, on all cells or those of a part."""
    seen: Array
    """(parts,) share of each part's surface with a cell nearby."""
    widths: Array
    """(parts,) minimum width of each part in cells, of a cone that of a layer per radius."""
    num_cells: int
    num_cells_above: int
    """Of the part above the lowest that has the fewest; of a single solid all."""
    num_cells_lowest: int
    """Of the lowest part."""
    bend: float = 0.0
    """BIC per cell by which curves explain the outlines of the parts better."""

    @property
    def probability(self) -> float:
        """Probability that an object is what the fit says, complete and sufficiently visible."""
        seen = SEEN.chance(np.log(np.maximum(self.seen, 1e-3))).prod()
        resolved = RESOLVED.chance(np.log(np.maximum(self.widths, 1e-3))).prod()
        fitting = FORM.chance(-self.criterion) * LEAD.chance(self.lead)
        enough = ENOUGH.chance(np.log(self.num_cells))
        enough *= ABOVE.chance(np.log(max(self.num_cells_above, 1)))
        enough *= LOWEST.chance(np.log(max(self.num_cells_lowest, 1)))
        return float(fitting * enough * seen * resolved * STRAIGHT.chance(-self.bend))
