"""Settings of the stereo stages: features, matching, triangulation."""

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from recon.settings.stage import Count, NonNegative, Positive, Share, given, table


@table
class FeatureSettings:
    """Selection of the feature points of an image (thesis 3.2, 3.3)."""

    method: Literal["steerable", "population"] = "steerable"
    """Source of strength and orientation: steerable filters, or population coding (3.2)."""
    share: Share = 0.10
    """Wanted number of features, as a share of the pixels; sets the threshold of the modulus."""
    threshold: NonNegative = 0.5
    """Smallest modulus of a feature, in grey levels, however few there are."""
    widths_px: tuple[Annotated[float, Field(ge=1.5, le=64)], ...] = Field(
        default=(1.5, 3.0, 6.0), min_length=1, max_length=8
    )
    """Widths of the filters, fine to coarse; the wavelength is 2.22 times as long."""


@table
class MatchingSettings:
    """Matching of the features of two images (thesis 3.4)."""

    matcher: str = "phase"
    """phase, vonmises, sgbm, or a plug-in's name."""
    min_disparity: int = 0
    """Of the search, pixels; included."""
    max_disparity: int = 20
    """Of the search, pixels; included."""
    max_row_offset_px: int = Field(default=0, ge=0)
    """Rows up and down that are searched too; on rectified pairs anything but 0 hurts."""
    cross_check: Literal["exact", "row"] = "exact"
    """Confirmation of a pair: by the choice of its right pixel among all left ones, or only
    against the other features of its row, which takes half the time."""
    support_sampling: Literal["half", "quarter"] = "half"
    """Share of the pixels round a point that supports its disparities."""
    model: str | None = None
    """File of the von Mises matcher's model; None = the one recon ships."""
    per_block: Count | None = None
    """At most so many pairs of each block of 32 x 32 pixels, so that they spread; None = all."""
    keep: Count | None = None
    """Number of the most confident pairs that are kept; None = all."""

    def searching(self, stated: tuple[int, int] | None) -> "MatchingSettings":
        """The same, over the search range that a recording states, but for what was given."""
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
    """Triangulation of pairs to coloured points (thesis 3.5, 4.5)."""

    colour_window_px: int = Field(default=3, ge=1)
    """Side of the square whose mean is the colour of a point."""
    max_sigma: Positive | None = None
    """Points whose depth is less sure than this many world units are doubtful; None = none."""
    min_probability: Share = 0.5
    """Points of matches that are right with less than this probability are doubtful."""


@table
class DenseSettings:
    """A disparity for every pixel (the thesis's future work)."""

    enabled: bool = False
    """Match every pixel too, and leave dense results."""
    method: Literal["semi-global", "opencv"] = "semi-global"
    """recon's own costs along eight directions, or OpenCV's StereoSGBM along three."""
    speck_px: int = Field(default=100, ge=0)
    """Patches of fewer pixels that stand apart are taken out."""
    fill_px: int = Field(default=8, ge=0)
    """Width of holes that are filled along the row with what lies behind; 0 = none."""
