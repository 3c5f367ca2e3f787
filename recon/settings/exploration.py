"""Settings of the explorer."""

from pydantic import Field

from recon.settings.stage import Count, Positive, table


@table
class ExplorationSettings:
    """The walk of the agent (thesis 4.4)."""

    controller: str = "frontier"
    """frontier, thesis, or the name of a plug-in."""
    max_pairs: Count = 1000
    """Largest number of pairs taken."""
    clearance: Positive = 10.0
    """Distance from which objects are inspected, world units."""
    object_turn_deg: float = Field(default=40.0, gt=0, le=180)
    """Angle between successive views around an object."""
    robot_turn_deg: float = Field(default=45.0, gt=0, le=180)
    """Angle between successive views when turning on the spot."""
    walk_clearance: Positive = 3.0
    """Distance kept from everything while moving, world units."""
    sight_range: Positive = 90.0
    """Distance up to which obstacles are reliably noticed and empty ground is known to be free,
    world units."""
    viewing_distance: Positive = 20.0
    """Distance up to which an obstacle is seen well enough to be mapped, world units."""
    start_position: tuple[float, float] | tuple[float, float, float] | None = None
    """Start position x, z, or x, y, z with the height of the cameras, world units; none = the start
    of the world, which is the middle of the floor in a simulated one."""
    start_heading_deg: float | None = None
    """Heading of the first view: 0 along -z, 90 along +x; none = the start of the world."""
