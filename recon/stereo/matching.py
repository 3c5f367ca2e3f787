"""The matchers, and the one door to them."""

from collections.abc import Callable
from importlib.metadata import entry_points

from recon.errors import InputError
from recon.records import Features, Matches
from recon.settings import MatchingSettings
from recon.stereo import phase

Matcher = Callable[[Features, Features, MatchingSettings], Matches]

MATCHERS: dict[str, Matcher] = {"phase": phase.match}
"""By name; others are found in the entry-point group `recon.matchers`."""


def match(left: Features, right: Features, settings: MatchingSettings) -> Matches:
    """Pair the features of two rectified pictures, most confident pairs first.

    Raises
    ------
    InputError
        Where the pictures differ in size, or nobody knows the matcher.
    """
    if left.grey.shape != right.grey.shape:
        raise InputError(
            f"left image has shape {left.grey.shape}, right {right.grey.shape}, but one is needed"
        )
    return find_matcher(settings.matcher)(left, right, settings)


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
