"""ROS 1 and ROS 2 bags (with the extra `ros`): two image topics, paired by their time stamps."""

import re
import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any

from recon.errors import InputError
from recon.libraries import load_extra
from recon.records import StereoPair
from recon.sequences.calibration.cameras import Calibration
from recon.sequences.calibration.files import read_calibration
from recon.sequences.calibration.rectification import Rectifier, rectifier
from recon.sequences.frames import Frame, Recording
from recon.sequences.poses import Trajectory
from recon.sequences.readers.bag_messages import (
    CAMERA_TYPE,
    IMAGE_TYPES,
    calibration_of,
    image,
    stamp_ns,
)
from recon.sequences.readers.folder import given_trajectory
from recon.settings import SequenceSettings

SIDES = {"left": re.compile(r"left|cam(era)?_?0"), "right": re.compile(r"right|cam(era)?_?1")}
"""What topics of the two cameras are called."""
MAX_STAMP_GAP_NS = 1_000_000
"""Between the two images of a pair: cameras that are triggered together differ by less."""
MAX_WAITING = 64
"""Images that are kept until their partner comes."""

Messages = dict[str, Any]
"""The messages of one moment, by their side."""


def is_bag(path: Path) -> bool:
    """Whether `path` is a bag of ROS 1, or a folder of ROS 2's."""
    if path.is_dir():
        return (path / "metadata.yaml").is_file()
    return path.suffix == ".bag"


def open_bag(path: Path, settings: SequenceSettings) -> Recording:
    """The recording in a bag; calib.* and poses.txt beside it come before what it holds."""
    images = _topics(path, IMAGE_TYPES)
    first = next(_messages(path, [images["left"]]), None)
    if first is None:
        raise InputError(f"{path} holds no images of the topic {images['left']}")
    calibration = _calibration(path, is_rectified="rect" in images["left"])
    height, width = image(first[1]).shape[:2]
    rectify = rectifier(calibration, (width, height))
    trajectory = given_trajectory(path.parent / "poses.txt", settings)
    frames = _BagFrames(path, images, rectify, trajectory, settings)
    return Recording(frames, disparity_range=calibration.disparity_range)


class _BagFrames:
    """Pairs of images in the order of the bag; each pass reads it anew."""

    def __init__(
        self,
        path: Path,
        topics: dict[str, str],
        rectify: Rectifier,
        trajectory: Trajectory | None,
        settings: SequenceSettings,
    ) -> None:
        self._path, self._topics, self._rectify = path, topics, rectify
        self._trajectory, self._poses, self._every = trajectory, settings.poses, settings.every

    def __len__(self) -> int:
        with _opened(self._path) as reader:
            lefts = [c.msgcount for c in reader.connections if c.topic == self._topics["left"]]
        return -(-int(sum(lefts)) // self._every)

    def __iter__(self) -> Iterator[Frame]:
        sides = {topic: side for side, topic in self._topics.items()}
        stream = ((sides[topic], m) for topic, m in _messages(self._path, [*sides]))
        for stamp, messages in islice(paired(stream), 0, None, self._every):
            load = partial(self._load, stamp, messages)
            yield Frame(name=str(stamp), stamp_s=stamp * 1e-9, load=load)

    def _load(self, stamp: int, messages: Messages) -> StereoPair:
        for side in SIDES:
            if side not in messages:
                raise InputError(f"it has no {side} image")
        T_world_left = None
        if self._trajectory is not None:
            T_world_left = self._trajectory.in_world(stamp * 1e-9)
            if T_world_left is None and self._poses == "given":
                raise InputError("there is no pose for it")
        left, right = image(messages["left"]), image(messages["right"])
        return self._rectify.pair(left, right, T_world_left, stamp * 1e-9, str(stamp))


def paired(stream: Iterator[tuple[str, Any]]) -> Iterator[tuple[int, Messages]]:
    """Messages ("left" or "right", message) put together by their time stamps, in order.

    A message without a partner comes alone.
    """
    waiting: dict[str, dict[int, Any]] = {side: {} for side in SIDES}
    for side, message in stream:
        stamp = stamp_ns(message)
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
    """What waited in vain for a partner, up to a time; it waits no more."""
    old = sorted((t, side) for side in SIDES for t in waiting[side] if end is None or t < end)
    return [(t, {side: waiting[side].pop(t)}) for t, side in old]


def _calibration(path: Path, *, is_rectified: bool) -> Calibration:
    for file in sorted(path.parent.glob("calib.*")):
        return read_calibration(file)
    infos = _topics(path, (CAMERA_TYPE,))
    left, right = (next(_messages(path, [infos[side]]), None) for side in SIDES)
    if left is None or right is None:
        raise InputError(f"{path} holds no camera info, and no calib.* lies beside it")
    return calibration_of(left[1], right[1], is_rectified=is_rectified)


def _topics(path: Path, types: tuple[str, ...]) -> dict[str, str]:
    """The topic of each side among those of some types; rectified ones before raw ones."""
    with _opened(path) as reader:
        topics = sorted({c.topic for c in reader.connections if c.msgtype in types})
    topics.sort(key=lambda topic: "rect" not in topic)
    found = {
        side: next((topic for topic in topics if name.search(topic.lower())), None)
        for side, name in SIDES.items()
    }
    missing = [side for side, topic in found.items() if topic is None]
    if missing:
        kind = types[0].rpartition("/")[2]
        raise InputError(
            f"{path} holds no {kind} topic of the {missing[0]} camera (of {topics or 'none'})"
        )
    return {side: topic for side, topic in found.items() if topic is not None}


def _messages(path: Path, topics: list[str]) -> Iterator[tuple[str, Any]]:
    """(topic, message) in the order of the bag."""
    with _opened(path) as reader:
        wanted = [c for c in reader.connections if c.topic in topics]
        for connection, _, data in reader.messages(connections=wanted) if wanted else ():
            yield connection.topic, reader.deserialize(data, connection.msgtype)


@contextmanager
def _opened(path: Path) -> Iterator[Any]:
    """An open reader; what it cannot read is an `InputError`."""
    highlevel = load_extra("rosbags.highlevel", "ros")
    faults = (highlevel.AnyReaderError, sqlite3.Error, OSError, ValueError)
    try:
        with highlevel.AnyReader([path]) as reader:
            yield reader
    except InputError:
        raise
    except faults as error:
        reason = str(error).partition("\n")[0]
        raise InputError(f"{path} cannot be read as a bag ({reason})") from error
