"""Pairs that are held, as the first ones pass, against what the recording says of them."""

from collections.abc import Iterator

from recon.notices import notify
from recon.records import PairSource, StereoPair
from recon.sequences.contradictions.motions import Step, pose_finding, step_between
from recon.sequences.contradictions.pairs import Finding, findings
from recon.sequences.frames import DerivedSource

SURVEYED = (0, 4, 9)
"""Numbers of the pairs whose two images are looked at."""
STEPPED = (1, 5, 9)
"""Numbers of the pairs whose motion since the one before is looked at."""


class CheckedPairs(DerivedSource):
    """The pairs of a source as they are; contradictions among the first ones are said, once.

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
        looked_at: list[list[Finding]] = []
        steps: list[Step] = []
        last: StereoPair | None = None
        for number, pair in enumerate(self.source):
            if number in SURVEYED:
                nearest = pair.rig.disparity_offset_px
                looked_at.append(findings(pair.left, pair.right, nearest_px=nearest))
            if self._has_given_poses and number in STEPPED and last is not None:
                step = step_between(last, pair)
                steps += [step] if step is not None else []
            last = pair
            if number == SURVEYED[-1]:
                self._say(looked_at, steps)
            yield pair
        self._say(looked_at, steps)

    def _say(self, looked_at: list[list[Finding]], steps: list[Step]) -> None:
        """Tell what most pairs show, and what the steps do."""
        if self._is_done:
            return
        self._is_done = True
        for code in dict.fromkeys(finding.code for pair in looked_at for finding in pair):
            found = [f for pair in looked_at for f in pair if f.code == code]
            if 2 * len(found) > len(looked_at):
                notify(code, found[0].text)
        # Poses are held against motions that stereo gives, which must be sound itself.
        of_poses = None if any(looked_at) else pose_finding(steps)
        if of_poses is not None:
            notify(of_poses.code, of_poses.text)
