"""Prospects: positions that a round may visit, also those on the far side of unseen ground.

A round planned over known ground only is short-sighted: an obstacle whose surroundings are unseen
has no place on it. So unseen ground is hoped to be free, as in D* (Stentz, 1994), and if the round
begins beyond it, the agent first looks at the way.
"""

from dataclasses import dataclass

import numpy as np

from recon.exploration.floor import Array, Mask, first_best
from recon.exploration.gains import AZIMUTHS_RAD, Visibility
from recon.exploration.paths import ShortestPaths, near_to, plan
from recon.exploration.scales import Scales
from recon.exploration.search import Search, Wanted
from recon.exploration.sides import Sides
from recon.exploration.state import State
from recon.exploration.tour import first_stop
from recon.exploration.viewpoints import vantage_points, viewpoints_round
from recon.exploration.ways import Ways, discs_of


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Prospects:
    """Positions to look from, and the ways to them."""

    known: ShortestPaths
    """The paths over known ground."""
    hoped: ShortestPaths
    """The paths if all unseen ground is free."""
    ways: Ways
    """The ways to C positions and between them; over unseen ground where the known does not do."""
    reached: Mask
    """(C,) True if a path over known ground leads there."""

    @classmethod
    def of(cls, state: State, unknown: Mask, wanted: Wanted, search: Search) -> "Prospects":
        """Here, the vantage points of the `unknown` ground (X, Z), and viewpoints of the wanted."""
        known, hoped = plan(state, unknown), plan(state, None)
        vantage = vantage_points(known, unknown, state.scales)
        around = viewpoints_round(known, wanted, search.clearance)
        beyond = viewpoints_round(hoped, wanted, search.clearance)
        beyond = beyond[~known.reaches(beyond)]
        near = np.vstack([state.place, vantage, around])
        ways = Ways(
            places=np.vstack([near, beyond]),
            lengths=np.append(known.length(near), hoped.length(beyond)),
            discs=discs_of((*state.obstacles, *state.detections), state.scales.walk_clearance),
        )
        reached = np.arange(len(ways.places)) < len(near)
        return cls(known=known, hoped=hoped, ways=ways, reached=reached)

    @property
    def places(self) -> Array:
        """(C, 2) x, z."""
        return self.ways.places

    def first_stop(
        self, visibility: Visibility, sides: Sides, unknown: Mask, scales: Scales
    ) -> tuple[int, float] | None:
        """Index of the reached position and azimuth of the next view; None if nothing is left."""
        stop = first_stop(self.ways, visibility, sides, unknown, scales, self.reached)
        if stop is None or self.reached[stop[0]]:
            return stop
        reached = visibility.only(self.reached)
        return self._towards(stop[0], reached, scales) or first_stop(
            self.ways, reached, sides, unknown, scales, self.reached
        )

    def _towards(
        self, goal: int, visibility: Visibility, scales: Scales
    ) -> tuple[int, float] | None:
        """The view that shows most of the unseen way to a position for its detour."""
        end, floor = self.places[goal], self.known.floor
        way = floor.mask(np.vstack([*self.hoped.cells_to(end), end]))
        unseen = near_to(way, scales.cells(scales.walk_clearance)) & ~floor.known_free
        area = visibility.area(unseen & ~floor.occupied)
        onward = np.hypot(*(self.places - end).T)
        detour = np.maximum(self.known.length(self.places) + onward - self.hoped.length(end), 0.0)
        score = area.max(axis=1) / (detour + scales.pair_cost)
        best = int(first_best(score))
        return (best, float(AZIMUTHS_RAD[first_best(area[best])])) if score[best] > 0.0 else None
