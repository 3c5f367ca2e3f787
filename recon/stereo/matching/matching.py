"""The matchers and their common interface."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError, check_type
from recon.plugins import Registry
from recon.records import Features, Matches, check_alike
from recon.settings import MatchingSettings

BLOCK_PX = 32
"""Side of the image blocks with a limited number of pairs each."""

Image = NDArray[np.uint8]
FeatureMatcher = Callable[[Features, Features, MatchingSettings], Matches]
"""Matches oriented feature points; the pairs are refined to sub-pixel precision afterwards."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ImageMatcher:
    """A matcher of whole images, such as a learned one or one on a GPU."""

    match: Callable[[Image, Image, MatchingSettings], Matches]
    """Returns the matches of both images (H, W) or (H, W, 3) with sigma; they are not refined."""


Matcher = FeatureMatcher | ImageMatcher

_ROOM = "recon.stereo.matching"
MATCHERS: Registry[Matcher] = Registry(
    "recon.matchers",
    "matcher",
    {name: f"{_ROOM}.{name}:match" for name in ("phase", "vonmises", "sgbm")},
)


def match(left: Features, right: Features, settings: MatchingSettings) -> Matches:
    """Match the features of two rectified images, most confident pairs first.

    Raises
    ------
    InputError
        If the images differ in size or filters, or the matcher is unknown.
    """
    check_alike(left, right)
    matcher = MATCHERS.load(settings.matcher)
    if isinstance(matcher, ImageMatcher):
        raise InputError(f"matcher {settings.matcher!r} takes images, but features are given")
    return _chosen(matcher(left, right, settings), settings)


def match_whole_images(left: Image, right: Image, settings: MatchingSettings) -> Matches | None:
    """Match two whole images; None if the matcher takes features."""
    matcher = MATCHERS.load(settings.matcher)
    if not isinstance(matcher, ImageMatcher):
        return None
    matches = matcher.match(left, right, settings)
    _check_matches(matches, settings.matcher, left.shape)
    return _chosen(matches, settings)


def _check_matches(matches: Matches, name: str, shape: tuple[int, ...]) -> None:
    """Raise `InputError` if the result of a plug-in is invalid."""
    check_type(f"the result of matcher {name!r}", matches, Matches)
    u, v = matches.points_px.T
    inside = (u >= 0) & (v >= 0) & (u <= shape[1] - 1) & (v <= shape[0] - 1)
    whole = np.isfinite(matches.disparity_px) & (matches.sigma_px > 0)
    if not (inside & whole).all():
        row = int(np.argmin(inside & whole))
        raise InputError(
            f"matcher {name!r} returned the point {matches.points_px[row]} with disparity "
            f"{matches.disparity_px[row]} and sigma {matches.sigma_px[row]}, but a point of the "
            "image, a finite disparity and a positive sigma are needed"
        )


def _chosen(matches: Matches, settings: MatchingSettings) -> Matches:
    """The most confident matches, as many as the settings keep."""
    if settings.per_block is not None:
        matches = matches.select(_is_among_best_of_block(matches, settings.per_block))
    return matches if settings.keep is None else matches.select(slice(0, settings.keep))


def _is_among_best_of_block(matches: Matches, quota: int) -> NDArray[np.bool_]:
    """Mask of the matches among the first `quota` of their block of the image."""
    u, v = matches.points_px.astype(np.int64).T // BLOCK_PX
    block = v * (u.max(initial=0) + 1) + u
    order = np.argsort(block, kind="stable")
    starts = np.searchsorted(block[order], block[order])
    among = np.empty(len(matches), dtype=bool)
    among[order] = np.arange(len(matches)) - starts < quota
    return among
