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
    """From cells to named objects (thesis 4.5)."""

    recogniser: str = "robust"
    """robust, thesis, or the name of a plug-in."""
    catalogue: Annotated[tuple[str, ...], BeforeValidator(_as_names)] = ("village",)
    """Names that are asked for: village, household, none, or TOML files; several at once."""
    unit: Literal["m"] | None = None
    """Unit of the world's lengths; None where it is not known."""
    ground: float | None = 0.0
    """Height of the ground; None = found as the largest plane."""
    ground_clearance: Positive | None = None
    """Cells lower than this over the ground are taken off, world units; None = one cell, over a
    plane that was found as much as its noise asks for."""
    min_voxels: Count = 12
    """Smallest object, in cells."""
    hue_tolerance_deg: float = Field(default=7.0, gt=0, le=180)
    """The thesis's ColorThreshold_Hue."""

    def clearance(self, cell_size: float) -> float:
        """Height over a known ground from which a cell's middle is above it, world units."""
        return cell_size if self.ground_clearance is None else self.ground_clearance
