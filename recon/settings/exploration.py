"""Settings of the explorer."""

from pydantic import Field

from recon.settings.stage import Count, Positive, table


@table
class ExplorationSettings:
    """How the agent walks (thesis 4.4)."""

    controller: str = "frontier"
    """A name of the table of controllers, or of a plug-in."""
    max_pairs: Count = 1000
    clearance: Positive = 10.0
    """Distance at which objects are looked at, world units."""
    object_turn_deg: float = Field(default=40.0, gt=0, le=180)
    """Turn round an object at each step."""
    robot_turn_deg: float = Field(default=45.0, gt=0, le=180)
    """Turn on the spot at each step."""
    walk_clearance: Positive = 3.0
    """Distance kept from everything while walking, world units."""
    sight_range: Positive = 90.0
    """How far off a thing is surely noticed: ground with nothing on it is known free up to here."""
    viewing_distance: Positive = 20.0
    """How far off a thing is seen well enough for the map, world units."""
