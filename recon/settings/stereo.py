"""Settings of the stereo stages: features, matching, triangulation."""

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from recon.settings.stage import Count, NonNegative, Positive, Share, given, table


@table
class FeatureSettings:
    """Selection of the feature points of an image (thesis 3.2, 3.3)."""

    method: Literal["steerable", "population"] = "steerable"
    """Source of feature strength and orientation: steerable filters, or population coding (3.2)."""
    share: Share = 0.10
    """Desired number of features as a share of the pixels; sets the threshold on the modulus."""
    threshold: NonNegative = 0.5
    """Smallest modulus of a feature, grey levels, however few features are left."""
    widths_px: tuple[Annotated[float, Field(ge=1.5, le=64)], ...] = Field(
        default=(1.5, 3.0, 6.0), min_length=1, max_length=8
    )
    """Filter widths, pixels, fine to coarse; wavelengths are 2.22 times as long."""


@table
class MatchingSettings:
    """Matching of the features of two images (thesis 3.4)."""

    matcher: str = "phase"
    """phase, vonmises, sgbm, or a plug-in's name."""
    min_disparity: int = 0
    """Smallest disparity searched, pixels."""
    max_disparity: int = 20
    """Largest disparity searched, pixels."""
    max_row_offset_px: int = Field(default=0, ge=0)
    """Rows above and below that are searched as well; on rectified pairs, leave it at 0."""
    cross_check: Literal["exact", "row"] = "exact"
    """Confirmation of a match: its right pixel chooses among all left pixels, or only among the
    features of its row, which takes two thirds of the time."""
    support_sampling: Literal["half", "quarter"] = "half"
    """Share of the neighbouring pixels that support a disparity; the exact confirmation always
    takes a quarter."""
    model: str | None = None
    """Model file of the von Mises matcher; none = the one that ships with recon."""
    per_block: Count | None = None
    """Largest number of matches per block of 32 x 32 pixels, to spread them evenly; none = all."""
    keep: Count | None = None
    """Number of matches kept, the most confident first; none = all."""
    residual_px: NonNegative | None = None
    """Root mean square error of disparities due to the calibration, pixels; none = what the
    calibration states, else that of typical recorded cameras; without a calibration, what the rows
    of the images suggest."""

    def searching(self, stated: tuple[int, int] | None) -> "MatchingSettings":
        """The same with the search range that a recording states, except for given values."""
        if stated is None:
            return self
        own = given(self)
        return MatchingSettings(**{"min_disparity": stated[0], "max_disparity": stated[1]} | own)

    @model_validator(mode="after")
    def _range_is_not_empty(self) -> Self:
        if self.max_disparity < self.min_disparity:
            raise ValueError(
                f"max_disparity {self.max_disparity} is below min_disparity {self.min_disparity}"
            )
        return self


@table
class TriangulationSettings:
    """Triangulation of matches to coloured points (thesis 3.5, 4.5)."""

    colour_window_px: int = Field(default=3, ge=1)
    """Side of the square window whose mean colour a point takes, pixels; at an outline, only the
    pixels on the side of its surface count, in a window three times as wide."""
    max_sigma: Positive | None = None
    """Largest sigma of a point, world units; points above it are set aside as doubtful; none = no
    limit."""
    min_probability: Share = 0.7
    """Smallest probability that a match is right; points below it are set aside as doubtful."""


@table
class DenseSettings:
    """A disparity for every pixel (the thesis's future work)."""

    enabled: bool = False
    """Match every pixel as well, and save dense results."""
    method: Literal["semi-global", "opencv"] = "semi-global"
    """recon's own costs aggregated along eight directions, or OpenCV's StereoSGBM along three."""
    speck_px: int = Field(default=100, ge=0)
    """Smallest isolated patch that is kept, pixels."""
    fill_px: int = Field(default=8, ge=0)
    """Largest width of holes filled along the row with the background, pixels; 0 = none."""
