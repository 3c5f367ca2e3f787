"""Pairs checked, as they pass, against the metadata of the recording."""

from collections.abc import Iterator

from recon.notices import notify
from recon.records import PairSource, StereoPair
from recon.sequences.contradictions.motions import Step, pose_finding, step_between
from recon.sequences.contradictions.pairs import Finding, findings
from recon.sequences.frames import DerivedSource

SURVEYED = (0, 4, 9)
"""Numbers of the pairs whose images are checked."""
STEPPED = (1, 5, 9)
"""Numbers of the first pairs whose motion since the previous one is checked."""
NUM_LATER = 12
"""Number of steps checked in the rest of the recording, evenly spaced."""


class CheckedPairs(DerivedSource):
    """The unchanged pairs of a source; contradictions are reported once.

    Only findings in most of the checked pairs are reported.
    """

    def __init__(self, source: PairSource, *, has_given_poses: bool) -> None:
        super().__init__(source)
        self._has_given_poses = has_given_poses
        self._is_done = False

    def __iter__(self) -> Iterator[StereoPair]:
        if self._is_done:
            yield from self.source
            return
        watch = _Watch(len(self.source) if self._has_given_poses else 0)
        for pair in self.source:
            watch.look_at(pair)
            yield pair
        watch.say_images()
        watch.say_poses()
        self._is_done = True


class _Watch:
    """Findings so far in one pass over the pairs."""

    def __init__(self, num_posed: int) -> None:
        self._num_pairs = 0
        self._last: StereoPair | None = None
        self._looked_at: list[list[Finding]] = []
        self._steps: list[Step] = []
        self._stepped = _stepped(num_posed)
        self._has_said_images = self._has_said_poses = False

    def look_at(self, pair: StereoPair) -> None:
        """Check the next pair, if it is one of the selected ones."""
        number = self._num_pairs
        if number in SURVEYED:
            nearest = pair.rig.disparity_offset_px
            self._looked_at.append(findings(pair.left, pair.right, nearest_px=nearest))
        if number in self._stepped and self._last is not None and not self._has_said_poses:
            step = step_between(self._last, pair)
            self._steps += [step] if step is not None else []
        if number == SURVEYED[-1]:
            self.say_images()
        if number >= STEPPED[-1] and number in self._stepped:
            self.say_poses()
        self._last = pair
        self._num_pairs += 1

    def say_images(self) -> None:
        """Report the findings in most of the checked pairs."""
        if self._has_said_images:
            return
        self._has_said_images = True
        for code in dict.fromkeys(finding.code for pair in self._looked_at for finding in pair):
            found = [f for pair in self._looked_at for f in pair if f.code == code]
            if 2 * len(found) > len(self._looked_at):
                notify(code, found[0].text)

    def say_poses(self) -> None:
        """Report contradictions of the last steps: poses may go wrong anywhere along the path."""
        # Poses are compared with motions from stereo, which must be sound itself.
        if self._has_said_poses or any(self._looked_at):
            return
        del self._steps[: -len(STEPPED)]
        found = pose_finding(self._steps)
        if found is not None:
            self._has_said_poses = True
            where = "" if self._num_pairs <= STEPPED[-1] + 1 else f" (near {self._steps[0].name})"
            notify(found.code, found.text + where)


def _stepped(num_pairs: int) -> frozenset[int]:
    """Numbers of the pairs whose motion is checked; none without given poses."""
    if not num_pairs:
        return frozenset()
    begin = STEPPED[-1] + 1
    every = max(1, (num_pairs - begin) // NUM_LATER)
    return frozenset([*STEPPED, *range(begin + every - 1, num_pairs, every)])
