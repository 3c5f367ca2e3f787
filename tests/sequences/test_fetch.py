"""The golden pair that `make setup` fetches to its committed calibration."""

from pathlib import Path

import numpy as np
import pytest

from recon.errors import InputError
from recon.sequences import open_sequence, read_truth
from recon.sequences.samples import fetch
from recon.settings import SequenceSettings

ROOT = Path(__file__).parents[2]


@pytest.fixture
def motorcycle(tmp_path):
    fetch("motorcycle", tmp_path)
    before = (tmp_path / "left.png").stat().st_mtime_ns
    fetch("motorcycle", tmp_path)  # changes nothing if everything is present
    assert (tmp_path / "left.png").stat().st_mtime_ns == before
    return tmp_path


def test_calibration_equals_the_committed_one(motorcycle):
    committed = ROOT / "data" / "motorcycle" / "calib.txt"
    assert (motorcycle / "calib.txt").read_text() == committed.read_text()


def test_unknown_sample_is_rejected_with_the_nearest_name(tmp_path):
    with pytest.raises(InputError, match=r"sample is 'motorbike', .*\(nearest: motorcycle\)"):
        fetch("motorbike", tmp_path)


@pytest.mark.parametrize("name", ["left.png", "calib.txt"])
def test_files_of_another_recording_are_refused_and_kept(tmp_path, name):
    (tmp_path / name).write_bytes(b"mine")
    with pytest.raises(InputError, match=rf"{name} is of another recording; give another -o"):
        fetch("motorcycle", tmp_path)
    assert (tmp_path / name).read_bytes() == b"mine"
    assert [one.name for one in tmp_path.iterdir()] == [name]


def test_interrupted_fetch_is_completed(motorcycle):
    (motorcycle / "right.png").unlink()
    fetch("motorcycle", motorcycle)
    assert (motorcycle / "right.png").is_file()


def test_truth_is_that_of_the_left_image(motorcycle):
    source = open_sequence(motorcycle, SequenceSettings())
    (pair,) = source
    assert pair.left.shape == (500, 741, 3)
    disparity, step = read_truth(motorcycle)
    assert step == 0
    known = np.isfinite(disparity)
    assert 0.9 < known.mean() < 0.95
    low, high = source.disparity_range
    assert low < np.nanmin(disparity) < np.nanmax(disparity) < high
    depth = pair.rig.depth(disparity[known])
    assert 2 < depth.min() < depth.max() < 6  # a garage
    v, u = np.nonzero(known & (np.arange(741) > 80))
    right = pair.right[v, np.rint(u - disparity[v, u]).astype(int)]
    other = pair.right[v, np.clip(np.rint(u + disparity[v, u]).astype(int), 0, 740)]
    left = pair.left[v, u].astype(int)
    assert np.median(np.abs(left - right)) < 6
    assert np.median(np.abs(left - other)) > 15
