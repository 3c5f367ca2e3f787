"""Left and right taken at different times, found by comparison with the previous pairs."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from recon.records import StereoPair
from recon.sequences.contradictions.finding import Finding
from recon.sequences.contradictions.survey import survey
from recon.sequences.depth import Image

REACH = 2
"""Maximum lag between the cameras that is searched for, in pairs."""
MIN_GAIN, MIN_MORE = 1.3, 0.08
"""Factor, and share, by which an image of another pair must fit better than the paired one."""


def moment_finding(pair: StereoPair, before: Sequence[StereoPair]) -> Finding | None:
    """The contradiction that images of two different pairs fit better than those of one pair.

    A rig at rest shows none, as all its images fit each other.

    Parameters
    ----------
    pair : StereoPair
    before : sequence of StereoPair
        The previous pairs, the last one first; up to `REACH` of them are used.
    """
    own = level_shares(pair.left, pair.right)
    shares = {words: level_shares(*images) for words, images in _partners(pair, before[:REACH])}
    words = max(shares, key=lambda one: shares[one].of_wanted, default="")
    if not shares or not _is_better(shares[words], own):
        return None
    return Finding(
        code="not-simultaneous",
        text=f"left and right were taken at different times: the right images are {words}, as "
        f"{shares[words].of_wanted:.0%} of the corners then lie in corresponding rows, "
        f"{own.of_wanted:.0%} as paired",
    )


def _partners(
    pair: StereoPair, before: Sequence[StereoPair]
) -> Iterator[tuple[str, tuple[Image, Image]]]:
    for number, other in enumerate(before, start=1):
        if other.rig != pair.rig:
            # As in a ring of views, where neighbouring pairs share one view.
            continue
        pairs = f"{number} pair{'s' if number > 1 else ''}"
        yield f"{pairs} late", (other.left, pair.right)
        yield f"{pairs} early", (pair.left, other.right)


class LevelShares(NamedTuple):
    """Shares of corners that lie in corresponding rows, weighted by how close the rows are."""

    of_wanted: float
    """Of the corners searched for."""
    of_seen: float
    """Of the corners found."""


def level_shares(left: Image, right: Image) -> LevelShares:
    """The fit of two images to each other as those of one pair."""
    made = survey(left, right)
    level = float(np.maximum(0.0, 1.0 - np.abs(made.seen.row_offset_px)).sum())
    return LevelShares(level / max(1, made.num_wanted), level / max(1, len(made.seen)))


def _is_better(other: LevelShares, own: LevelShares) -> bool:
    """True if the other images fit better than the paired ones.

    Images of a rig that moves along its baseline all have corresponding rows, and those nearest to
    each other share most corners: only corners out of their rows contradict a pair.
    """
    more_of_wanted = max(MIN_GAIN * own.of_wanted, own.of_wanted + MIN_MORE)
    return other.of_wanted >= more_of_wanted and other.of_seen >= MIN_GAIN * own.of_seen
