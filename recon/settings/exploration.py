"""Settings of the explorer."""

from pydantic import Field

from recon.settings.stage import Count, Positive, table


@table
class ExplorationSettings:
    """The walk of the agent (thesis 4.4)."""

    controller: str = "frontier"
    """A name of the table of controllers, or of a plug-in."""
    max_pairs: Count = 1000
    """The exploration ends after so many pairs at the latest."""
    clearance: Positive = 10.0
    """Distance at which objects are looked at, world units."""
    object_turn_deg: float = Field(default=40.0, gt=0, le=180)
    """Turn round an object at each step."""
    robot_turn_deg: float = Field(default=45.0, gt=0, le=180)
    """Turn on the spot at each step."""
    walk_clearance: Positive = 3.0
    """Distance kept from everything while walking, world units."""
    sight_range: Positive = 90.0
    """Distance up to which an obstacle is surely noticed, and ground without one known free."""
    viewing_distance: Positive = 20.0
    """Distance up to which an obstacle is seen well enough for the map, world units."""
    start_position: tuple[float, float] | tuple[float, float, float] | None = None
    """x, z of the start, or x, y, z with the height of the eyes, world units; None = where the
    world begins, which is the middle of a simulated one's floor."""
    start_heading_deg: float | None = None
    """Direction of the first view: 0 along -z, 90 along +x; None = as the world begins."""
