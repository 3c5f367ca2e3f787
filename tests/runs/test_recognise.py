"""`recon recognise`, `learn` and `catalogue` on the command line."""

import numpy as np
import pytest

from recon.cli.main import main
from recon.exports import ply
from recon.exports.formats import write
from recon.records import PointCloud
from recon.voxelmap import VoxelMap
from tests.commands import answer
from tests.described_objects import assert_described

BALL, CAN = (0.1, 0.1), (0.03, 0.12)


def objects_on_a_table(rng, *, table=True):
    """Sample a ball and a can on a table, y up, in metres."""
    unit = rng.normal(size=(4000, 3))
    ball = 0.1 * unit / np.linalg.norm(unit, axis=1, keepdims=True) + [0.2, 0.1, 0.0]
    turn, height = rng.uniform(0, 2 * np.pi, 4000), rng.uniform(0, 0.12, 4000)
    can = np.column_stack([0.04 * np.cos(turn) - 0.2, height, 0.04 * np.sin(turn)])
    board = rng.uniform([-0.5, 0, -0.4], [0.5, 0, 0.4], (20_000, 3))
    return (ball, can, board) if table else (ball, can)


def as_cloud(points):
    return PointCloud(points=points, colours=np.full(points.shape, 120, np.uint8))


@pytest.fixture(scope="module")
def desk(tmp_path_factory):
    path = tmp_path_factory.mktemp("desk") / "desk.ply"
    write(as_cloud(np.concatenate(objects_on_a_table(np.random.default_rng(0)))), path)
    return path


def test_cloud_with_a_column_of_objects_is_written(desk, tmp_path, capsys):
    target = tmp_path / "out.ply"
    report = answer(capsys, "recognise", desk, "-o", target)
    assert len(report["objects"]) == 2
    assert {one["label"] for one in report["objects"]} == {"unknown"}
    assert all(one["probability"] is None for one in report["objects"])
    for found in report["objects"]:
        assert_described(found, has_views=False)
    assert [plane["role"] for plane in report["planes"]] == ["ground"]
    columns = ply.read(target)
    assert set(np.unique(columns["object"])) == {-1, 0, 1}
    assert (columns["object"][-20_000:] == -1).mean() > 0.95
    assert main(["recognise", str(desk), "-o", str(target)]) == 2


def test_colourless_cloud_gives_objects_of_unknown_colour(tmp_path, capsys):
    plain = np.concatenate(objects_on_a_table(np.random.default_rng(0), table=False))[::8]
    write(PointCloud(points=plain), tmp_path / "plain.ply")
    plain_map = VoxelMap(cell_size=0.01)
    plain_map.insert(PointCloud(points=plain))
    plain_map.save(tmp_path / "plain.npz")
    for name in ("plain.ply", "plain.npz"):
        report = answer(capsys, "recognise", tmp_path / name)
        assert [one["code"] for one in report["warnings"]] == ["colour-missing"]
        for found in report["objects"]:
            assert_described(found, has_views=False, has_colours=False)


def test_run_has_y_up(tmp_path, capsys):
    (tmp_path / "settings.toml").touch()
    voxel_map = VoxelMap(cell_size=0.1)
    voxel_map.insert(as_cloud(np.zeros((5, 3))))
    voxel_map.save(tmp_path / "map.npz")
    for path in (tmp_path, tmp_path / "map.npz"):
        assert main(["recognise", str(path), "--up", "z"]) == 2
        assert "up is 'z', but" in capsys.readouterr().err


def test_names_with_sizes_need_a_scale(desk, capsys):
    named = answer(capsys, "recognise", desk, "--catalogue", "household", "--unit", "m")
    assert sorted(one["label"] for one in named["objects"]) == ["ball", "mug"]
    assert {one["box"]["unit"] for one in named["objects"]} == {"m"}
    assert named["warnings"] == []
    without = answer(capsys, "recognise", desk, "--catalogue", "household")
    assert [one["code"] for one in without["warnings"]] == ["names-need-scale"]
    assert {one["box"]["unit"] for one in without["objects"]} == {None}


def test_empty_catalogue_gives_a_notice(capsys):
    assert main(["catalogue", "check", "none"]) == 0
    assert capsys.readouterr().out == "no kinds: nothing is named\n"


def test_invalid_line_of_a_catalogue_is_named(tmp_path, capsys):
    assert main(["catalogue", "check", "household"]) == 0
    assert "body: sphere, radius 0.02 to 0.15 m" in capsys.readouterr().out
    wrong = tmp_path / "wrong.toml"
    wrong.write_text(
        '[[object]]\nname = "ball"\nparts = [\n    { role = "body", shapes = ["sphere"] },\n]\n\n'
        '[[object]]\nname = "egg"\nmin_seen = 2.0\nparts = [{ role = "body", shapes = ["cone"] }]\n'
    )
    assert main(["catalogue", "check", str(wrong)]) == 2
    assert f"{wrong}:9: object.1.min_seen" in capsys.readouterr().err


def test_learned_kind_is_added_to_a_catalogue_and_recognised(desk, tmp_path, capsys):
    kinds = tmp_path / "kinds.toml"
    examples = []
    for seed in range(1, 4):
        path = tmp_path / f"ball_{seed}.ply"
        write(as_cloud(objects_on_a_table(np.random.default_rng(seed), table=False)[0]), path)
        examples.append(path)
    report = answer(capsys, "learn", *examples, "--name", "globe", "-o", kinds)
    assert report["num_examples"] == 3
    assert any(group["used"] for group in report["descriptors"])
    found = answer(capsys, "recognise", desk, "--catalogue", kinds)
    assert sorted(one["label"] for one in found["objects"]) == ["globe", "unknown"]
    assert main(["learn", str(examples[0]), "--name", "orb", "-o", str(kinds)]) == 2
    assert "orb cannot be distinguished from globe" in capsys.readouterr().err
