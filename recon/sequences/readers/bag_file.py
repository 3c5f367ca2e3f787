"""The topics and messages of a ROS 1 or 2 bag, read by rosbags."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from recon.errors import InputError
from recon.libraries import load_extra

MAX_MESSAGES = 1 << 40
"""Maximum number of messages of a topic."""


def topics_of(path: Path, types: tuple[str, ...]) -> list[str]:
    """Names of the topics of a bag with the given types, sorted."""
    with opened(path) as reader:
        return sorted({c.topic for c in reader.connections if c.msgtype in types})


def connections(path: Path) -> list[tuple[str, str, int]]:
    """Every topic of a bag, sorted, with the type and the number of its messages."""
    with opened(path) as reader:
        return sorted((c.topic, c.msgtype, int(c.msgcount)) for c in reader.connections)


def num_messages(path: Path, topic: str) -> int:
    """Number of messages of a topic, as the bag states it."""
    with opened(path) as reader:
        number = sum(int(c.msgcount) for c in reader.connections if c.topic == topic)
        if not 0 <= number <= MAX_MESSAGES:
            raise InputError(f"{path} claims {number} messages, but 0 to {MAX_MESSAGES} are needed")
    return number


def read_messages(path: Path, topics: list[str]) -> Iterator[tuple[str, int, Any]]:
    """(topic, time of the bag in ns, message) in the order of the bag."""
    with opened(path) as reader:
        wanted = [c for c in reader.connections if c.topic in topics]
        for connection, received, data in reader.messages(connections=wanted) if wanted else ():
            yield connection.topic, received, reader.deserialize(data, connection.msgtype)


@contextmanager
def opened(path: Path) -> Iterator[Any]:
    """An open reader; failures become an `InputError`."""
    highlevel = load_extra("rosbags.highlevel", "ros")
    try:
        with highlevel.AnyReader([path], default_typestore=_usual_types()) as reader:
            yield reader
    except InputError:
        raise
    # rosbags and its database libraries raise errors of any kind for damaged bags.
    except Exception as error:
        reason = str(error).partition("\n")[0] or type(error).__name__
        raise InputError(f"{path} cannot be read as a bag ({reason})") from error


def _usual_types() -> Any:
    """Message definitions for ROS 2 bags without their own."""
    typesys = load_extra("rosbags.typesys", "ros")
    return typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
