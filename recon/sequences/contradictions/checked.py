"""Pairs held, as they pass, against what the recording says of them."""

from collections.abc import Iterator

from recon.notices import notify
from recon.records import PairSource, StereoPair
from recon.sequences.contradictions.motions import Step, pose_finding, step_between
from recon.sequences.contradictions.pairs import Finding, findings
from recon.sequences.frames import DerivedSource

SURVEYED = (0, 4, 9)
"""Numbers of the pairs whose two images are looked at."""
STEPPED = (1, 5, 9)
"""Numbers of the first pairs whose motion since the one before is looked at."""
NUM_LATER = 12
"""Steps that are looked at in the rest of the recording, at even distances."""


class CheckedPairs(DerivedSource):
    """The pairs of a source as they are; what contradicts them is said, once.

    What most of the looked-at pairs show is told, not what one of them does.
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
    """Findings of one pass over the pairs so far."""

    def __init__(self, num_posed: int) -> None:
        self._num_pairs = 0
        self._last: StereoPair | None = None
        self._looked_at: list[list[Finding]] = []
        self._steps: list[Step] = []
        self._stepped = _stepped(num_posed)
        self._has_said_images = self._has_said_poses = False

    def look_at(self, pair: StereoPair) -> None:
        """Hold the next pair against what is said of it, where it is one of those looked at."""
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
        """Tell what most of the looked-at pairs show."""
        if self._has_said_images:
            return
        self._has_said_images = True
        for code in dict.fromkeys(finding.code for pair in self._looked_at for finding in pair):
            found = [f for pair in self._looked_at for f in pair if f.code == code]
            if 2 * len(found) > len(self._looked_at):
                notify(code, found[0].text)

    def say_poses(self) -> None:
        """Tell what the last steps contradict: poses may go wrong anywhere on the way."""
        # They are held against motions that stereo gives, which must be sound itself.
        if self._has_said_poses or any(self._looked_at):
            return
        del self._steps[: -len(STEPPED)]
        found = pose_finding(self._steps)
        if found is not None:
            self._has_said_poses = True
            where = "" if self._num_pairs <= STEPPED[-1] + 1 else f" (near {self._steps[0].name})"
            notify(found.code, found.text + where)


def _stepped(num_pairs: int) -> frozenset[int]:
    """Numbers of the pairs whose motion is looked at; none where no poses are given."""
    if not num_pairs:
        return frozenset()
    begin = STEPPED[-1] + 1
    every = max(1, (num_pairs - begin) // NUM_LATER)
    return frozenset([*STEPPED, *range(begin + every - 1, num_pairs, every)])
