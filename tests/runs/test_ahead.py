"""Pairs are matched ahead: in order, with any number of workers, and only once."""

import numpy as np
import pytest

from recon.camera import StereoRig
from recon.cli import main
from recon.records import StereoPair
from recon.runs import ahead
from recon.runs.ahead import read_ahead

pytestmark = pytest.mark.usefixtures("without_figures")

FILES = ("map.npz", "cloud.ply", "objects.json", "trajectory.txt")


def test_items_are_prefetched_in_order_and_exceptions_are_raised():
    def source():
        yield from range(5)
        raise OSError("the disk went away")

    got = []
    with pytest.raises(OSError, match="the disk went away"):
        got.extend(read_ahead(source()))
    assert got in ([], list(range(5)))
    assert list(read_ahead(range(5))) == list(range(5))
    assert list(read_ahead([])) == []


def test_no_more_items_are_read_than_requested():
    read = []
    pairs = read_ahead(read.append(i) or i for i in range(100))
    assert [next(pairs), next(pairs)] == [0, 1]
    pairs.close()
    assert len(read) <= 2 + ahead.DEPTH + 1


@pytest.fixture(scope="module")
def drive(data_dir, tmp_path_factory):
    run = tmp_path_factory.mktemp("ahead") / "whole"
    argv = ["reconstruct", str(data_dir / "kitti_odometry" / "sequence_1"), "--every", "10",
            "--quality", "fast", "-q"]  # fmt: skip
    assert main([*argv, "-o", str(run)]) == 0
    return argv, run


def same(one, other):
    return all((one / name).read_bytes() == (other / name).read_bytes() for name in FILES)


@pytest.mark.data
def test_number_of_workers_does_not_change_the_bytes(drive, tmp_path, monkeypatch):
    argv, run = drive
    assert main([*argv, "-j", "2", "-o", str(tmp_path / "two")]) == 0
    assert same(run, tmp_path / "two")
    monkeypatch.setenv("NUMBA_NUM_THREADS", "1")
    assert main([*argv, "-o", str(tmp_path / "one")]) == 0
    assert same(run, tmp_path / "one")


def test_number_of_parallel_pairs_is_limited_by_memory():
    def pair(width, height):
        image = np.zeros((height, width), np.uint8)
        centre = {"cx_left_px": width / 2, "cx_right_px": width / 2, "cy_px": height / 2}
        rig = StereoRig(width=width, height=height, focal_px=500.0, baseline=0.1, **centre)
        return StereoPair(left=image, right=image, rig=rig)

    assert ahead._num_at_once([pair(1226, 370)], 51) == 9
    assert ahead._num_at_once([pair(1226, 370)], 1) == 1  # its rows are split among the threads
    assert ahead._num_at_once([pair(4000, 3000)], 51) == 1
    assert ahead._num_at_once([], 0) == 1


@pytest.mark.data
def test_interrupted_run_resumes_at_the_next_pair(drive, tmp_path, monkeypatch):
    argv, run = drive
    matched = []

    def cut(pair, settings):
        if len(matched) == 3:
            raise KeyboardInterrupt
        matched.append(pair.name)
        return whole(pair, settings)

    whole = ahead.match_points
    monkeypatch.setattr(ahead, "match_points", cut)
    argv = [*argv, "-o", str(tmp_path / "cut")]
    assert main(argv) == 130
    monkeypatch.setattr(ahead, "match_points", lambda *a: matched.append("") or whole(*a))
    assert main([*argv, "--resume"]) == 0
    assert len(matched) == 6  # none twice
    assert same(run, tmp_path / "cut")
    assert not (tmp_path / "cut" / "partial").exists()
