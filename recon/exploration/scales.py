"""Lengths used for the explorer's decisions, all relative to lengths of the settings."""

from dataclasses import dataclass

from recon.settings import Settings


@dataclass(frozen=True, slots=True, kw_only=True)
class Scales:
    """Lengths and areas in world units; another unit gives the same walk."""

    cell: float
    """Side of a map cell, also that of a floor cell."""
    clearance: float
    """Distance from which objects are viewed."""
    walk_clearance: float
    """Distance kept from obstacles while walking."""
    viewing_distance: float
    """Distance up to which a view is good enough for the map."""
    eye_height: float

    @classmethod
    def of(cls, settings: Settings) -> "Scales":
        """The scales of some settings."""
        exploration = settings.exploration
        return cls(
            cell=settings.map.cell_size,
            clearance=exploration.clearance,
            walk_clearance=exploration.walk_clearance,
            viewing_distance=exploration.viewing_distance,
            eye_height=settings.eyes.eye_height,
        )

    def cells(self, length: float) -> float:
        """A length in cells, without rounding errors that depend on the unit."""
        return round(length / self.cell, 9)

    @property
    def gaze(self) -> float:
        """Convergence distance of the cameras if there is no target."""
        return self.viewing_distance

    @property
    def same_place(self) -> float:
        """Distance within which two views in the same direction show the same."""
        return 0.15 * self.viewing_distance

    @property
    def pair_cost(self) -> float:
        """Cost of a pair as a walking distance."""
        return 0.75 * self.viewing_distance

    @property
    def stop_cost(self) -> float:
        """Cost of a stop on a ground round as a walking distance."""
        return 1.5 * self.viewing_distance

    @property
    def side_area(self) -> float:
        """Area of unknown ground with the same value as a new side of an object."""
        return 5.0 * self.viewing_distance**2

    @property
    def much_area(self) -> float:
        """Area above which ground hardly counts while there are objects to look at."""
        return 0.75 * self.viewing_distance**2

    @property
    def min_area(self) -> float:
        """Minimum area of unknown ground for a view to be worth a stop."""
        return 0.2 * self.viewing_distance**2

    @property
    def same_obstacle(self) -> float:
        """Distance from a mapped obstacle within which a new point belongs to it."""
        return 3.0 * self.cell

    @property
    def unknown_clearance(self) -> float:
        """Distance kept from unknown ground far from obstacles, where another one may begin."""
        return 2.0 / 3.0 * self.walk_clearance

    @property
    def hidden_reach(self) -> float:
        """Distance from an obstacle within which unknown ground may be its unseen side."""
        return 1.5 * self.walk_clearance

    @property
    def border(self) -> int:
        """Cells between unknown ground and a position to look at it from."""
        return max(1, round(4.0 / 3.0 * self.walk_clearance / self.cell))

    @property
    def blocks(self) -> tuple[int, int]:
        """Sides in cells of the squares with one viewpoint each: on the frontier, elsewhere."""
        side = self.viewing_distance / self.cell
        return max(1, round(0.4 * side)), max(1, round(0.8 * side))
