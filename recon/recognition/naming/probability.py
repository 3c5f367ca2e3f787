"""The probability that a thing is of its kind, whole, and seen enough: a conjunction.

Each condition has a logistic of its own and all of them are multiplied, so that nothing that is
missing can be made up for by something else. The numbers began as a fit by maximum likelihood to
440 simulated objects, half of them of no kind, seen in part and with noise, and to clumps of
recorded maps, which weighed as much together; they were then chosen by hand among a few
combinations that keep false names of recorded maps out. That of a surface that is hardly seen is a
principle.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Logistic:
    """A condition that holds with a chance of one half at `middle`, more beyond it."""

    middle: float
    steepness: float

    def chance(self, value: Array | float) -> Array:
        """Chance at a value; of an array for each."""
        exponent = self.steepness * (np.asarray(value, dtype=np.float64) - self.middle)
        chances: Array = 1.0 / (1.0 + np.exp(-np.clip(exponent, -60.0, 60.0)))
        return chances


FORM = Logistic(middle=0.1, steepness=3.5)
"""Deviance a cell under that of a thing of no form: the fit must mean something."""
LEAD = Logistic(middle=0.3, steepness=7.0)
"""Deviance a cell under that of the best lone solid: a box is not a tree because one fits it."""
SEEN = Logistic(middle=float(np.log(0.03)), steepness=2.5)
"""Log of the share of a part's surface that is seen."""
RESOLVED = Logistic(middle=float(np.log(0.6)), steepness=4.0)
"""Log of the least width of a part in cells."""

ORDERED = Logistic(middle=-0.9, steepness=4.0)
"""The same of an assembly, whose parts in their places say more than how near the cells lie."""
ENOUGH = Logistic(middle=float(np.log(25.0)), steepness=4.0)
"""Log of the count of cells: a handful of them lies on anything."""
EXPLAINED = Logistic(middle=0.7, steepness=14.0)
"""Share of the cells on the parts of an assembly."""
SHOWN = Logistic(middle=float(np.log(12.0)), steepness=4.0)
"""Log of the count of cells of a plane that an assembly needs: any few lie on one."""
NEARNESS = Logistic(middle=0.0, steepness=6.0)
"""Log of the distance to a learned kind's examples, below its threshold."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Evidence:
    """The evidence for a fit, whatever its kind."""

    criterion: float
    """BIC a cell, less that of a thing of no form."""
    lead: float
    """Lead over the best rival of no kind, on all cells or on a part's."""
    seen: Array
    """(parts,) share of each part's surface with a cell near it."""
    widths: Array
    """(parts,) least width of each part in cells."""
    num_cells: int

    @property
    def probability(self) -> float:
        """That a thing is what the fit says, whole, and seen enough."""
        seen = SEEN.chance(np.log(np.maximum(self.seen, 1e-3))).prod()
        resolved = RESOLVED.chance(np.log(np.maximum(self.widths, 1e-3))).prod()
        fitting = FORM.chance(-self.criterion) * LEAD.chance(self.lead)
        return float(fitting * ENOUGH.chance(np.log(self.num_cells)) * seen * resolved)
