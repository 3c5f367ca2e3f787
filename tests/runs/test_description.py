"""`recon info`: the basic facts about anything that recon reads or writes."""

import json

import cv2
import numpy as np
import pytest

from recon.cli import main
from recon.exports import write
from recon.records import Mesh, PointCloud
from recon.runs.description import describe
from recon.settings import Settings
from recon.settings.files import to_toml
from recon.voxelmap import VoxelMap
from tests.commands import answer
from tests.sequences.recordings import middlebury_keys, write_folder, write_pair_dir, write_ros1

POINTS = np.array([[1.0, 2, 3], [4, 5, 6], [7, 8, 9]])


def info(capsys, path):
    return answer(capsys, "info", path)


@pytest.mark.parametrize(
    "ending", [".ply", ".pcd", ".las", ".npz", ".npy", ".csv", ".xyz", ".parquet"]
)
def test_cloud_in_any_format_is_described(tmp_path, capsys, ending):
    attributes = {"label": np.array([1, 2, 3], np.uint8)}
    write(PointCloud(points=POINTS, attributes=attributes), tmp_path / f"cloud{ending}")
    facts = info(capsys, tmp_path / f"cloud{ending}")
    assert (facts["kind"], facts["num_points"], facts["has_colour"]) == ("cloud", 3, False)
    assert list(facts["columns"]) == ["label"]
    assert np.allclose(facts["high"], [7, 8, 9])


@pytest.mark.parametrize("ending", [".ply", ".obj", ".stl", ".off", ".glb"])
def test_mesh_in_any_format_is_described(tmp_path, capsys, ending):
    mesh = Mesh(vertices=np.eye(3), triangles=np.array([[0, 1, 2]], np.int32))
    write(mesh, tmp_path / f"mesh{ending}")
    facts = info(capsys, tmp_path / f"mesh{ending}")
    assert (facts["kind"], facts["num_vertices"], facts["num_triangles"]) == ("mesh", 3, 1)
    assert facts["area"] == pytest.approx(np.sqrt(3) / 2, rel=1e-6)


@pytest.mark.parametrize("ending", [".npz", ".vti", ".bt", ".zarr", ".yaml", ".pgm"])
def test_map_in_any_format_is_described(tmp_path, capsys, ending):
    voxel_map = VoxelMap(0.5)
    voxel_map.insert(PointCloud(points=POINTS))
    write(voxel_map, tmp_path / f"map{ending}")
    facts = info(capsys, tmp_path / f"map{ending}")
    assert facts["kind"] == "map"
    assert facts["num_cells"] == (2 if ending in (".yaml", ".pgm") else 3)
    assert facts["cell_size"] == 0.5


@pytest.mark.parametrize(
    ("name", "content", "expected"),
    [
        ("calib.txt", "P0: 7 0 3 0 0 7 2 0 0 0 1 0\nP1: 7 0 3 -3.5 0 7 2 0 0 0 1 0\n",
         {"kind": "calibration", "baseline": 0.5, "is_rectified": True}),
        ("poses.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 3 0 1 0 4 0 0 1 0\n",
         {"kind": "trajectory", "num_poses": 2, "length": 5.0}),
        ("trajectory.txt", "0 0 0 0 0 0 0 1\n0 3 4 0 0 0 0 1\n",
         {"kind": "trajectory", "num_poses": 2, "length": 5.0}),
        ("points.txt", "x y z r g b nx ny\n1 2 3 4 5 6 7 8\n", {"kind": "cloud", "num_points": 1}),
        ("points.txt", "1 2 3\n", {"kind": "cloud", "num_points": 1}),
        ("metrics.json", '{"num_pairs": 2, "curve": [[1, 2, 3]], "warnings": []}',
         {"kind": "metrics", "num_pairs": 2}),
        ("settings.toml", to_toml(Settings()), {"kind": "settings"}),
        ("jobs.toml", '[[job]]\nname = "a"\ncommand = "explore"\ninput = "x"\n',
         {"kind": "jobs", "num_jobs": 1}),
        ("objects.json", '{"objects": [], "failures": {"small": 2}}',
         {"kind": "objects", "num_objects": 0, "failures": {"small": 2}}),
    ],
)  # fmt: skip
def test_text_files_are_identified_by_their_content(tmp_path, capsys, name, content, expected):
    (tmp_path / name).write_text(content)
    facts = info(capsys, tmp_path / name)
    assert expected.items() <= facts.items()
    assert facts["warnings"] == []


def test_images_disparities_and_matches_are_described(tmp_path, capsys):
    image = np.arange(12, dtype=np.uint16).reshape(3, 4)
    cv2.imwrite(str(tmp_path / "a.png"), image)
    facts = info(capsys, tmp_path / "a.png")
    assert (facts["kind"], facts["width"], facts["height"], facts["bits"]) == ("image", 4, 3, 16)
    cv2.imwrite(str(tmp_path / "a.pfm"), image.astype(np.float32))
    facts = info(capsys, tmp_path / "a.pfm")
    assert (facts["kind"], facts["known"]) == ("disparity", pytest.approx(11 / 12))
    np.savez(tmp_path / "m.npz", points_px=np.zeros((2, 2)), disparity_px=np.array([1.0, 3.0]))
    facts = info(capsys, tmp_path / "m.npz")
    assert (facts["kind"], facts["num_matches"]) == ("matches", 2)
    assert facts["disparity_px"] == {"lowest": 1.0, "median": 2.0, "highest": 3.0}


def test_human_readable_output_is_a_table(tmp_path, capsys):
    one = {
        "id": 0, "label": "pine", "probability": 0.5, "centre": [1.0, 2.0, 3.0],
        "size": [1.0, 1.0, 1.0], "num_voxels": 7, "views": 1, "parts": [],
    }  # fmt: skip
    (tmp_path / "objects.json").write_text(json.dumps({"objects": [one], "failures": {}}))
    code = main(["info", str(tmp_path / "objects.json")])
    out = capsys.readouterr().out
    assert code == 0
    assert "id  label  probability  centre   size     num_voxels" in out
    assert "0   pine   0.5          1, 2, 3  1, 1, 1  7" in out


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("a.json", b"[1, 2]"), ("a.json", b"{"), ("a.json", b"[" * 100000), ("a.json", b"\xff"),
        ("a.json", b'{"objects": 3}'), ("a.json", b'{"objects": [{"id": "x"}]}'),
        ("a.json", b'{"num_pairs": ' + b"9" * 5000 + b"}"), ("a.toml", b"x = "),
        ("a.toml", b"a" + b".a" * 50000 + b" = 1"), ("a.toml", b"[matching]\nnosuch = 1\n"),
        ("a.toml", b"x = " + b"[" * 50000), ("a.yaml", b"- " * 50000),
        ("a.yaml", b"a: &a [1,1]\n" + b"".join(b"b%d: [*a, *a]\n" % n for n in range(1000))),
        ("a.txt", b"hello world"), ("a.txt", b""), ("a.pfm", b"PF\n"), ("a.bag", b"no bag"),
        ("a.unknown", b""), ("a.npz", b""),
    ],
)  # fmt: skip
def test_damaged_documents_are_reported_in_one_line(tmp_path, capsys, name, content):
    (tmp_path / name).write_bytes(content)
    assert main(["info", str(tmp_path / name)]) in (1, 2)
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.count("\n") == 1
    assert name in captured.err


def test_topics_and_format_of_a_bag_are_described(tmp_path):
    write_ros1(tmp_path / "drive")
    facts = describe(tmp_path / "drive")
    assert facts["format"] == "bag"
    assert len(facts["topics"]) == 4
    write_folder(tmp_path / "plain")
    assert describe(tmp_path / "plain")["format"] == "folder"


@pytest.mark.parametrize("has_poses", [True, False])
def test_recording_is_described_with_and_without_poses(tmp_path, capsys, has_poses):
    path = write_folder(tmp_path / "drive")
    if not has_poses:
        (path / "poses.txt").unlink()
    assert info(capsys, path)["has_poses"] is has_poses


def test_pair_has_no_pose(tmp_path, capsys):
    facts = info(capsys, write_pair_dir(tmp_path / "pair"))
    assert (facts["num_pairs"], facts["has_poses"]) == (1, False)


def test_error_in_a_calibration_is_reported(tmp_path, capsys):
    path = tmp_path / "calib.txt"
    path.write_text(middlebury_keys().replace("ndisp=16", "ndisp=-5"))
    assert main(["info", str(path)]) == 2
    assert "ndisp" in capsys.readouterr().err


def test_name_of_a_scene_that_ships_is_described_as_its_file(capsys):
    assert info(capsys, "cottage")["kind"] == "scene"
