"""The benchmark's row counts paths against the oracle's, where there is an oracle."""

import math
import runpy
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

TOOL = Path(__file__).parents[2] / "tools" / "benchmarks" / "robustness.py"


@pytest.fixture(scope="module")
def tool():
    """What the benchmark defines; it adds to the path what it imports."""
    before = [*sys.path]
    yield SimpleNamespace(**runpy.run_path(str(TOOL)))
    sys.path[:] = before


def metrics(oracle_path, pairs_until_objects=2):
    return {
        "curve": [[1, 0.0, None], [2, 60.0, None], [3, 90.0, None]], "num_pairs": 3,
        "pairs_until_objects": pairs_until_objects, "path_length": 90.0, "num_objects": 0,
        "oracle_path": oracle_path, "min_clearance": 3.0,
    }  # fmt: skip


def run(tool, **known):
    recognition = SimpleNamespace(objects=[])
    done = SimpleNamespace(
        metrics=metrics(**known), recognition=recognition, stop_reason="all known"
    )
    return tool.Run(things=[], done=done)


def test_path_until_objects_ends_where_the_last_one_got_its_name(tool):
    assert tool.path_until_objects(metrics(40.0)) == 1.5
    assert tool.path_until_objects(metrics(40.0, pairs_until_objects=3)) == 2.25


def test_path_until_objects_is_nothing_without_objects(tool):
    assert tool.path_until_objects(metrics(40.0, pairs_until_objects=0)) == 0.0


def test_world_without_an_oracle_is_counted_apart(tool):
    row = tool.row_of([run(tool, oracle_path=None), run(tool, oracle_path=45.0)])
    assert row.without_oracle == 1
    assert row.until_objects == pytest.approx(60.0 / 45.0)
    assert row.path_share == 2.0


def test_worlds_without_any_oracle_have_no_share(tool):
    row = tool.row_of([run(tool, oracle_path=None)])
    assert math.isnan(row.until_objects)
    assert math.isnan(row.path_share)
