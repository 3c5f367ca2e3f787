"""ROS 1 and ROS 2 bags (with the extra `ros`): two image topics, paired by timestamp."""

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any

from recon.errors import InputError
from recon.records import StereoPair
from recon.sequences.calibration.cameras import Calibration
from recon.sequences.calibration.files import read_calibration
from recon.sequences.calibration.rectification import Rectifier, rectifier
from recon.sequences.depth import Stretch, stretch_of
from recon.sequences.frames import Frame, Recording
from recon.sequences.poses import GivenPoses
from recon.sequences.readers.bag_file import num_messages, read_messages, topics_of
from recon.sequences.readers.bag_messages import (
    CAMERA_TYPE,
    IMAGE_TYPES,
    calibration_of,
    image,
    stamp_ns,
)
from recon.sequences.readers.folder import given_poses
from recon.sequences.readers.reader import Reader
from recon.settings import SequenceSettings

SIDES = ("left", "right")
NAMES = (
    {"left": re.compile(r"left"), "right": re.compile(r"right")},
    {"left": re.compile(r"infra_?1"), "right": re.compile(r"infra_?2")},
    {"left": re.compile(r"cam(era)?_?0"), "right": re.compile(r"cam(era)?_?1")},
    {"left": re.compile(r"cam(era)?_?1"), "right": re.compile(r"cam(era)?_?2")},
)
"""Words for the two cameras in topic names; the first entry that identifies both sides is used."""
ENDINGS = (".bag", ".mcap", ".db3")
MAX_STAMP_GAP_NS = 1_000_000
"""Maximum time between the two images of a pair; synchronised cameras differ by less."""
MAX_WAITING = 64
"""Maximum number of images kept until their partner arrives."""

NUM_FIRST = 8
"""Number of first messages searched for an image of each side, which gives size and levels."""
Messages = dict[str, Any]
"""The messages of one time, by side."""


def is_bag(path: Path) -> bool:
    """True if `path` is a ROS 1 bag, or a ROS 2 bag as folder or single file."""
    if path.is_dir():
        return (path / "metadata.yaml").is_file()
    return path.suffix in ENDINGS


def open_bag(path: Path, settings: SequenceSettings) -> Recording:
    """The recording in a bag; calib.* and poses.txt beside it take precedence over its content."""
    images = image_topics(path, settings)
    stream = read_messages(path, [*images.values()])
    first = {topic: message for topic, _, message in islice(stream, NUM_FIRST)}
    for topic in images.values():
        if topic not in first:
            first[topic] = next((m for _, _, m in read_messages(path, [topic])), None)
        if first[topic] is None:
            raise InputError(f"{path} contains no images of the topic {topic}")
    samples = {topic: image(message) for topic, message in first.items()}
    calibration = _calibration(path, images)
    height, width = samples[images["left"]].shape[:2]
    rectify = rectifier(calibration, (width, height))
    given = given_poses(path.parent, settings)
    frames = _BagFrames(
        path=path,
        topics=images,
        load=_Loader(
            rectify=rectify,
            eight_bits=stretch_of([*samples.values()]),
            given=given,
            needs_pose=settings.poses == "given" and given is not None,
        ),
        wanted=slice(0, None, settings.every),
    )
    return Recording(frames, disparity_range=calibration.disparity_range)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Loader:
    """The conversion of two messages into a pair."""

    rectify: Rectifier
    eight_bits: Stretch
    given: GivenPoses | None
    needs_pose: bool

    def __call__(self, stamp: int, messages: Messages) -> StereoPair:
        """The rectified pair of one time."""
        for side in SIDES:
            if side not in messages:
                raise InputError(f"it has no {side} image")
        T_world_left = None if self.given is None else self.given.in_world(stamp * 1e-9)
        if T_world_left is None and self.needs_pose:
            raise InputError("there is no pose for it")
        left, right = (self.eight_bits(image(messages[side])) for side in SIDES)
        return self.rectify.pair(left, right, T_world_left, stamp * 1e-9, str(stamp))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _BagFrames:
    """Pairs of images in the order of the bag; each iteration reads it again."""

    path: Path
    topics: dict[str, str]
    load: _Loader
    wanted: slice

    def __len__(self) -> int:
        return len(range(num_messages(self.path, self.topics["left"]))[self.wanted])

    def __getitem__(self, part: slice) -> "_BagFrames":
        rows = range(num_messages(self.path, self.topics["left"]))[self.wanted][part]
        return replace(self, wanted=slice(rows.start, rows.stop, rows.step))

    def __iter__(self) -> Iterator[Frame]:
        sides = {topic: side for side, topic in self.topics.items()}
        stream = (
            (sides[topic], stamp_ns(message) or received, message)
            for topic, received, message in read_messages(self.path, [*sides])
        )
        rows = self.wanted
        for stamp, messages in islice(paired(stream), rows.start, rows.stop, rows.step):
            yield Frame(
                name=str(stamp), stamp_s=stamp * 1e-9, load=partial(self.load, stamp, messages)
            )


def paired(stream: Iterable[tuple[str, int, Any]]) -> Iterator[tuple[int, Messages]]:
    """Messages ("left" or "right", stamp, message) paired by their stamps, in order.

    A message without a partner is yielded alone.
    """
    waiting: dict[str, dict[int, Any]] = {side: {} for side in SIDES}
    for side, stamp, message in stream:
        other = "right" if side == "left" else "left"
        partner = min(waiting[other], key=lambda t: abs(t - stamp), default=None)
        if partner is None or abs(partner - stamp) > MAX_STAMP_GAP_NS:
            waiting[side][stamp] = message
            if len(waiting[side]) > MAX_WAITING:
                yield from _alone(waiting, min(waiting[side]) + 1)
            continue
        match = waiting[other].pop(partner)
        yield from _alone(waiting, min(partner, stamp))
        yield stamp if side == "left" else partner, {side: message, other: match}
    yield from _alone(waiting, None)


def _alone(waiting: dict[str, dict[int, Any]], end: int | None) -> list[tuple[int, Messages]]:
    """Remove messages without a partner, up to a time."""
    old = sorted((t, side) for side in SIDES for t in waiting[side] if end is None or t < end)
    return [(t, {side: waiting[side].pop(t)}) for t, side in old]


def _calibration(path: Path, images: dict[str, str]) -> Calibration:
    """The calibration beside a bag, else that of the cameras used."""
    for file in sorted(path.parent.glob("calib*.*")):
        return read_calibration(file)
    infos = {side: _info_topic(path, topic) for side, topic in images.items()}
    if None in infos.values():
        try:
            return read_calibration(path.parent)
        except InputError as error:
            raise InputError(
                f"{path} holds no camera info, and there is no calib.* beside it"
            ) from error
    left, right = (
        next((m for _, _, m in read_messages(path, [str(infos[s])])), None) for s in SIDES
    )
    if left is None or right is None:
        raise InputError(f"{path} holds no camera info, and there is no calib.* beside it")
    return calibration_of(left, right, is_rectified="rect" in images["left"])


def _info_topic(path: Path, image_topic: str) -> str | None:
    """The camera info beside an image topic, or the only one with its name."""
    topics = topics_of(path, (CAMERA_TYPE,))
    side = image_topic.rstrip("/").rpartition("/")[0]
    near = [t for t in topics if t.rpartition("/")[0] in (side, image_topic)]
    if near:
        return near[0]
    # cam0/image_raw and cam0_info, left/image and left_camera_info: both have the same prefix.
    stem = side.rpartition("/")[2]
    named = [t for t in topics if stem and re.search(rf"(^|/){re.escape(stem)}[^/]*", t)]
    return named[0] if len(named) == 1 else None


def image_topics(path: Path, settings: SequenceSettings) -> dict[str, str]:
    """The topic of each side: the requested one, or the one indicated by its name.

    Raises
    ------
    InputError
        With the available image topics.
    """
    topics = topics_of(path, IMAGE_TYPES)
    asked = {"left": settings.left_topic, "right": settings.right_topic}
    for side, topic in asked.items():
        if topic is not None and topic not in topics:
            raise InputError(
                f"{side} topic is {topic!r}, but one of {', '.join(topics) or 'none'} is needed"
            )
    chosen = _named_sides([topic for topic in topics if topic not in asked.values()])
    found = {side: asked[side] or chosen.get(side) for side in SIDES}
    missing = [side for side, topic in found.items() if topic is None]
    if missing or found["left"] == found["right"]:
        side = missing[0] if missing else "right"
        raise InputError(
            f"{path} holds no Image topic of the {side} camera that is identified by its name (of "
            f"{', '.join(topics) or 'none'}): give --left-topic and --right-topic"
        )
    return {side: str(topic) for side, topic in found.items()}


def _named_sides(topics: list[str]) -> dict[str, str]:
    """The topic of each side by its name; the last informative part decides."""
    ranked = sorted(topics, key=_likelihood)
    for names in NAMES:
        found = {
            side: next((topic for topic in ranked if _says(names, side, topic)), None)
            for side in SIDES
        }
        if None not in found.values():
            return {side: str(topic) for side, topic in found.items()}
    return {}


def _says(names: dict[str, re.Pattern[str]], side: str, topic: str) -> bool:
    """True if the last part of a topic that indicates a side indicates this one."""
    other = "right" if side == "left" else "left"
    for part in reversed(topic.lower().split("/")):
        if names[side].search(part):
            return True
        if names[other].search(part):
            return False
    return False


def _likelihood(topic: str) -> tuple[bool, bool, str]:
    """A sorting key: rectified images before raw ones, depth and masks last."""
    name = topic.lower()
    return any(word in name for word in ("depth", "mask", "disparity")), "rect" not in name, topic


READER = Reader(fits=is_bag, open=open_bag, has_topics=True)
