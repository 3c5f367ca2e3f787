"""Settings of recognition."""

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field

from recon.settings.stage import Count, Positive, table


def _as_names(value: Any) -> Any:
    """One name, several, or none, as a tuple."""
    if value is None:
        return ()
    return (value,) if isinstance(value, str) else value


@table
class RecognitionSettings:
    """Recognition: from cells to named objects (thesis 4.5)."""

    recogniser: str = "robust"
    """robust, thesis, or the name of a plug-in."""
    catalogue: Annotated[tuple[str, ...], BeforeValidator(_as_names)] = ("village",)
    """Kinds to look for: village, household, none, or TOML files; more than one may be given."""
    unit: Literal["m"] | None = None
    """Unit of lengths in the world; none = unknown."""
    ground: float | None = 0.0
    """Height of the ground, world units; none = the largest level plane."""
    ground_clearance: Positive | None = None
    """Height above the ground below which cells are removed, world units; none = one cell, or what
    the noise of an estimated ground plane calls for."""
    min_voxels: Count = 12
    """Smallest number of cells in an object."""
    hue_tolerance_deg: float = Field(default=7.0, gt=0, le=180)
    """Largest difference in hue within an object; the thesis's ColorThreshold_Hue."""

    @property
    def unit_name(self) -> str:
        """Name of the unit of lengths, as figures and pages write it."""
        return self.unit or "world units"

    def clearance(self, cell_size: float) -> float:
        """Height above a known ground from which a cell centre counts as above it, world units."""
        return cell_size if self.ground_clearance is None else self.ground_clearance
