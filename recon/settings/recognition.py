"""Settings of recognition."""

from typing import Literal

from pydantic import Field

from recon.settings.stage import Count, Positive, table


@table
class RecognitionSettings:
    """From cells to named objects (thesis 4.5)."""

    recogniser: Literal["robust", "thesis"] = "robust"
    catalogue: str | None = None
    """TOML file of the names and their rules; None = the shipped one."""
    ground: float | None = 0.0
    """Height of the ground; None = found as the largest plane."""
    ground_clearance: Positive = 1.0
    """Cells whose middle lies lower than this over the ground are taken off."""
    min_voxels: Count = 12
    """Smallest object, in cells."""
    hue_tolerance_deg: float = Field(default=7.0, gt=0, le=180)
    """The thesis's ColorThreshold_Hue."""
