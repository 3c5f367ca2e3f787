"""The matchers, and the one door to them."""

from collections.abc import Callable
from importlib.metadata import entry_points

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError
from recon.records import Features, Matches, check_alike
from recon.settings import MatchingSettings
from recon.stereo.matching import phase, sgbm, vonmises

BLOCK_PX = 32
"""Side of the blocks over which pairs are spread."""

Matcher = Callable[[Features, Features, MatchingSettings], Matches]

MATCHERS: dict[str, Matcher] = {
    "phase": phase.match,
    "vonmises": vonmises.match,
    "sgbm": sgbm.match,
}
"""By name; others are found in the entry-point group `recon.matchers`."""


def match(left: Features, right: Features, settings: MatchingSettings) -> Matches:
    """Pair the features of two rectified images, most confident pairs first.

    Raises
    ------
    InputError
        Where the images differ in size or filters, or nobody knows the matcher.
    """
    check_alike(left, right)
    matches = find_matcher(settings.matcher)(left, right, settings)
    if settings.per_block is not None:
        matches = matches.select(_is_among_best_of_block(matches, settings.per_block))
    return matches.select(slice(0, settings.keep))


def _is_among_best_of_block(matches: Matches, quota: int) -> NDArray[np.bool_]:
    """Which matches are among the first `quota` of their block of the image."""
    u, v = matches.points_px.astype(np.int64).T // BLOCK_PX
    block = v * (u.max(initial=0) + 1) + u
    order = np.argsort(block, kind="stable")
    starts = np.searchsorted(block[order], block[order])
    among = np.empty(len(matches), dtype=bool)
    among[order] = np.arange(len(matches)) - starts < quota
    return among


def find_matcher(name: str) -> Matcher:
    """The matcher of a name, recon's own or a plug-in's."""
    if name in MATCHERS:
        return MATCHERS[name]
    plugins = entry_points(group="recon.matchers")
    if name in plugins.names:
        matcher: Matcher = plugins[name].load()
        return matcher
    known = ", ".join([*MATCHERS, *sorted(plugins.names)])
    raise InputError(f"matcher is {name!r}, but one of {known} is needed")
