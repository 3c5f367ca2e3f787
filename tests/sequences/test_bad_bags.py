"""Faulty bags are rejected in one line; messages without a partner are kept apart."""

import re

import pytest

from recon.errors import InputError
from tests.sequences.read_back import read
from tests.sequences.recordings import (
    write_ros1,
    write_ros2,
)


def test_empty_bag_is_rejected(tmp_path):
    from rosbags.rosbag2 import Writer

    with Writer(tmp_path / "bag", version=9):
        pass
    with pytest.raises(InputError, match="holds no Image topic of the left camera"):
        read(tmp_path / "bag")


def test_damaged_bag_is_rejected(tmp_path):
    path = write_ros1(tmp_path / "recording")
    path.write_bytes(path.read_bytes()[:5000])
    with pytest.raises(InputError, match="cannot be read as a bag"):
        read(path)


def test_unpaired_bag_messages_are_returned_alone():
    from types import SimpleNamespace

    from recon.sequences.readers.bag import paired

    def message(side, ns):
        stamp = SimpleNamespace(sec=0, nanosec=ns)
        return side, ns, SimpleNamespace(header=SimpleNamespace(stamp=stamp))

    late = [("left", 0), ("right", 10), ("left", 5_000_000), ("left", 9_000_000),
            ("right", 9_000_400), ("right", 20_000_000)]  # fmt: skip
    found = [(t, sorted(sides)) for t, sides in paired(iter(message(*m) for m in late))]
    assert found == [
        (0, ["left", "right"]),
        (5_000_000, ["left"]),
        (9_000_000, ["left", "right"]),
        (20_000_000, ["right"]),
    ]


def test_calibration_beside_a_bag_takes_precedence(tmp_path):
    path = write_ros2(tmp_path / "recording")
    (path.parent / "calib.txt").write_text("cam0=[1 2]\n")
    with pytest.raises(InputError, match=r"cam0 is '.1 2.', but 9 numbers are needed"):
        read(path)


def test_multi_line_reason_is_joined_into_one(tmp_path):
    path = write_ros2(tmp_path / "recording")
    (path / "metadata.yaml").write_text("rosbag2: [1, 2\nb: 3\n")
    with pytest.raises(InputError, match="cannot be read as a bag") as caught:
        read(path)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("number", ["many", "9" * 30])
def test_impossible_message_counts_are_rejected(tmp_path, number):
    path = write_ros2(tmp_path / "recording") / "metadata.yaml"
    path.write_text(re.sub(r"message_count: \d+", f"message_count: {number}", path.read_text()))
    with pytest.raises(InputError, match=r"many|claims 9+ messages"):
        read(path.parent)
