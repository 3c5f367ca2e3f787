"""Labels in random worlds, counted."""

import json

import numpy as np
import pytest

from recon.cli import main
from recon.errors import InputError
from recon.records import FoundObject
from recon.runs.worlds import NOT_FOUND, judged_names, summary
from recon.world.objects import TrueObject


def true_object(x, label="pine tree"):
    size = np.array([8.0, 12.0, 8.0])
    return TrueObject(id=0, label=label, centre=np.array([x, 6.0, 0]), size=size, visuals=())


def found_object(x, label):
    size = np.array([8.0, 12.0, 8.0])
    centre = np.array([x, 5.0, 0.5])
    return FoundObject(id=0, label=label, probability=0.9, centre=centre, size=size, num_voxels=90)


def test_true_objects_match_the_nearest_within_their_width():
    true = (true_object(0.0), true_object(20.0), true_object(40.0, "cottage"))
    found = (found_object(1.0, "pine tree"), found_object(18.0, "apple tree"))
    assert [one.found for one in judged_names(true, found)] == [
        "pine tree",
        "apple tree",
        NOT_FOUND,
    ]
    counts = summary(judged_names(true, found))
    assert (counts["num_right"], counts["num_objects"]) == (1, 3)
    assert counts["confusion"] == {
        "cottage": {NOT_FOUND: 1}, "pine tree": {"apple tree": 1, "pine tree": 1},
    }  # fmt: skip
    with pytest.raises(InputError, match="at least one world"):
        summary([])


def test_one_world_is_run_from_the_command_line(tmp_path, capsys):
    out = tmp_path / "worlds"
    argv = ["evaluate", "--worlds", "1", "-o", str(out), "--set", "exploration.max_pairs=5"]
    assert main([*argv, "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["robust"]["num_objects"] == report["thesis"]["num_objects"] == 6
    assert {path.name for path in (out / "figures").glob("*.png")} == {
        "confusion.png", "confusion_thesis.png", "reliability.png",
    }  # fmt: skip
    assert main(["evaluate"]) == 2
