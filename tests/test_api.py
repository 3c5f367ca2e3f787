"""`import recon`: the functions for Python callers, their results, and rejected arguments."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import recon
from recon.settings import MatchingSettings, Settings

PAIR = Path(__file__).parents[1] / "data" / "motorcycle"
RIG = recon.StereoRig(
    width=8, height=6, focal_px=10.0, cx_left_px=3.5, cx_right_px=3.5, cy_px=2.5, baseline=0.1
)
IMAGE = np.zeros((6, 8), np.uint8)
STRETCHED = np.array([np.eye(4), np.diag([2.0, 1.0, 1.0, 1.0])])
WORLD = SimpleNamespace(start=print, take=print)
CLOUD = recon.PointCloud(points=np.zeros((3, 3)), colours=np.zeros((3, 3), np.uint8))


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: recon.VoxelMap("x"), "cell_size is 'x', but a number > 0 is needed"),
        (lambda: recon.VoxelMap(None), "cell_size is None"),
        (lambda: recon.VoxelMap(float("nan")), "cell_size is nan"),
        (lambda: recon.VoxelMap(0), "cell_size is 0"),
        (lambda: recon.VoxelMap(True), "cell_size is True"),
        (lambda: recon.VoxelMap().insert(None), "cloud is of type NoneType"),
        (lambda: recon.VoxelMap().insert(np.zeros((3, 3))), "PointCloud is needed"),
        (lambda: recon.VoxelMap().insert(CLOUD, origin="here"), "origin is 'here'"),
        (lambda: recon.VoxelMap().insert(CLOUD, view="first"), "view is 'first'"),
        (lambda: recon.VoxelMap().insert(CLOUD, view=-1), "view is -1, but a number >= 0"),
        (lambda: recon.read(3), "path is 3, but a path is needed"),
        (lambda: recon.write(CLOUD, None), "path is None, but a path is needed"),
        (
            lambda: recon.write("cloud", "a.ply"),
            "data is a str, but a cloud",
        ),
        (lambda: recon.VoxelMap().merge("map"), "other is of type str"),
        (lambda: recon.VoxelMap().occupied("many"), "min_count is 'many'"),
        (lambda: recon.PointCloud(points=[[0, 0, 0]], colours=None), "points is a list"),
        (lambda: recon.PointCloud(points=CLOUD.points, colours="red"), "colours is a str"),
        (lambda: recon.View(position="here", target=(0, 0, 0)), "position is 'here'"),
        (lambda: recon.View(position=(0, 0), target=(0, 0, 0)), "position has shape"),
        (lambda: recon.View(position=(0, 0, 0), target=None), "target"),
        (lambda: recon.View(position=(0, 0, 0), target=(0, 0, 1), near="x"), "near is 'x'"),
        (lambda: recon.StereoPair(left="a.png", right="b.png", rig=RIG), "left image is of type"),
        (lambda: recon.StereoPair(left=IMAGE, right=IMAGE, rig=None), "rig is of type NoneType"),
        (
            lambda: recon.StereoPair(left=IMAGE, right=IMAGE, rig=RIG, stamp_s=float("nan")),
            "stamp_s is nan",
        ),
        (
            lambda: recon.StereoPair(left=IMAGE, right=IMAGE, rig=RIG, T_world_left="here"),
            "T_world_left",
        ),
        (lambda: recon.match_pair(IMAGE, None), "right image is of type NoneType"),
        (
            lambda: recon.match_pair(IMAGE, IMAGE, max_disparity="64"),
            "max_disparity is '64', but a whole number",
        ),
        (lambda: recon.explore(WORLD, controller=3), "controller 3 has no next_view and no info"),
        (lambda: recon.World.from_file(3), "path is 3, but a path is needed"),
        (lambda: recon.VoxelMap().save(None), "path is None, but a path is needed"),
        (lambda: recon.VoxelMap.load(None), "path is None, but a path is needed"),
        (lambda: recon.PartitionedMap(None), "path is None, but a path is needed"),
        (lambda: recon.World.from_file("cottage").take(None), "view is of type NoneType"),
        (lambda: recon.explore(WORLD), "start is of type NoneType, but View is needed"),
        (lambda: recon.read("a.ply", sample=-1), "sample is -1, but a number >= 0"),
        (lambda: recon.write(CLOUD, "a.ply", up="x"), "up is 'x', but y or z is needed"),
        (lambda: recon.write(CLOUD, "a.ply", box=3), r"box has shape \(\), but \(2, 3\)"),
        (lambda: recon.Settings(map=3), "Settings.map is 3, but a MapSettings or its values"),
        (lambda: recon.execute(None), "job is of type NoneType, but Job is needed"),
        (lambda: recon.Job(kind="explore", inputs=3), "inputs is of type int"),
        (lambda: recon.Job(kind="explore", arguments=3), "arguments is of type int"),
        (lambda: recon.match_pair(IMAGE, IMAGE, max_disparity=-1), "below min_disparity"),
        (lambda: recon.match_pair(IMAGE, IMAGE, quality="good"), "quality is 'good'"),
        (lambda: recon.process_pair("pair", recon.Settings(), recon.VoxelMap()), "pair is of"),
        (lambda: recon.Mapper("fast"), "settings is of type str"),
        (lambda: recon.Mapper().process(None), "pair is of type NoneType"),
        (lambda: recon.Settings(stereo={}), "stereo"),
        (lambda: MatchingSettings(max_disparity="far"), "max_disparity is 'far'"),
        (lambda: recon.Job(kind="dance"), "kind of job is 'dance'.*nearest"),
        (lambda: recon.Job(kind="explore", settings="fast"), "settings is of type str"),
        (lambda: recon.Job(kind="explore", seed=-1), "seed is -1"),
        (lambda: recon.reconstruct(None), "path is None"),
        (lambda: recon.reconstruct("nowhere"), "nowhere does not exist"),
        (lambda: recon.explore("village"), "source is 'village', but something with start"),
        (lambda: recon.open_sequence(PAIR, evry=2), "evry is unknown; .*every"),
        (lambda: recon.recognise("map.npz"), "data is a str"),
        (lambda: recon.recognise(CLOUD, up="x"), "up is 'x'"),
        (lambda: recon.fit("points"), "points"),
        (lambda: recon.PointCloud(points=CLOUD.points, attributes=None), "attributes is of type"),
        (lambda: CLOUD.transformed("pose"), "T_target_source is 'pose', but numbers"),
        (lambda: CLOUD.transformed(None), r"T_target_source has shape \(\)"),
        (lambda: recon.open_sequence(PAIR)[0], "index of a recording is 0, but a slice"),
        (lambda: recon.open_sequence(PAIR)[::-1], "but a slice such as 0:9 is needed"),
        (lambda: recon.open_sequence(PAIR, poses="estimated")[-1], "recording is -1, but a slice"),
        (lambda: recon.open_sequence(PAIR, poses="estimated")[:1][0], "recording is 0, but a"),
        (lambda: replace(RIG, width=7.5), "rig width is 7.5, but a whole number is needed"),
        (lambda: recon.register("matchers", 3, None), "name is of type int, but str"),
        (lambda: recon.execute(recon.Job(kind="explore"), 3), "path is 3, but a path"),
        (lambda: recon.execute(recon.Job(kind="explore"), events=3), "events is of type int"),
        (
            lambda: recon.Trajectory(stamps_s=np.arange(2.0), T_world_left=STRETCHED),
            r"T_world_left\[1\] is not a rigid motion \(R R\^T is off by 3",
        ),
        (lambda: recon.rectifier(PAIR, "big"), "size is 'big', but .width, height. in pixels"),
        (lambda: recon.rectifier(PAIR, (741, 500)).pair([1], IMAGE), "left image is of type list"),
    ],
)
def test_invalid_argument_is_named(call, message):
    with pytest.raises(recon.InputError, match=message):
        call()


def test_search_range_may_be_given_by_position():
    left = np.random.default_rng(1).integers(0, 256, (40, 60), np.uint8)
    for match in (recon.match_pair, recon.match_dense):
        by_name = match(left, left, min_disparity=-4, max_disparity=6, quality="fast")
        assert np.array_equal(match(left, left, -4, 6, "fast").disparity_px, by_name.disparity_px)


def test_records_have_a_readable_repr():
    voxel_map = recon.VoxelMap(0.5, channels=["views"])
    assert repr(voxel_map) == "VoxelMap(0 cells of 0.5, keeps views)"
    assert repr(CLOUD) == "PointCloud(3 points)"
    assert repr(recon.Matches.none()) == "Matches(0 pairs, disparities - to - px)"
    pair = recon.StereoPair(left=IMAGE, right=IMAGE, rig=RIG)
    assert repr(pair) == "StereoPair(pair: 8 x 6 grey, without a pose, 0 s)"
    assert "0 pairs" in repr(recon.Mapper())
    unknown = np.full((2, 4), np.nan, np.float32)
    dense = recon.DisparityMap(disparity_px=unknown, sigma_px=unknown)
    assert repr(dense) == "DisparityMap(4 x 2 pixels, 0% known)"
    found = recon.recognise(recon.VoxelMap())
    assert repr(found) == "Recognition(objects: none; 1 planes)"
    assert repr(recon.open_sequence(PAIR)) == "PosedPairs(1 pairs)"


def test_keywords_are_settings_with_or_without_their_stage():
    assert Settings.of(max_disparity=60).matching.max_disparity == 60
    assert Settings.of(matching={"max_disparity": 60}).matching.max_disparity == 60
    assert Settings.of(**{"matching.max_disparity": 60}).matching.max_disparity == 60
    assert Settings.of(matching=MatchingSettings(keep=5)).matching.keep == 5
    mixed = Settings.of(recon.Settings(), quality="fast", every=3)
    assert (mixed.features.share, mixed.sequence.every) == (0.05, 3)
    with pytest.raises(recon.InputError, match="several stages"):
        Settings.of(max_sigma=1.0)


def test_defaults_follow_from_the_kind_and_given_settings_are_kept():
    job = recon.Job(kind="worlds", arguments={"worlds": 1})
    resolved = job.resolved().settings
    assert (resolved.matching.min_disparity, resolved.matching.max_disparity) == (-10, 20)
    assert (resolved.features.share, resolved.matching.cross_check) == (0.05, "exact")
    own = recon.Job(kind="worlds", settings=Settings.of(share=0.1, min_disparity=0))
    resolved = own.resolved().settings
    assert (resolved.features.share, resolved.matching.min_disparity) == (0.1, 0)
    assert resolved.matching.max_disparity == 20


def num_points(settings):
    voxel_map = recon.VoxelMap(0.1)
    for pair in recon.open_sequence(PAIR):
        result = recon.process_pair(pair, settings, voxel_map)
    return len(result.cloud)


def test_search_range_of_a_recording_is_used():
    stated = num_points(Settings.of(quality="fast"))
    assert stated == num_points(Settings.of(quality="fast", max_disparity=70, min_disparity=0))
    assert num_points(Settings.of(quality="fast", max_disparity=20)) < 0.6 * stated


def test_folder_is_reconstructed_to_a_map():
    done = recon.reconstruct(PAIR, quality="fast")
    assert done.map.num_cells > 1000
    assert len(done.voxels) > 500
    assert len(done.trajectory) == 1
    assert "occupied cells" in repr(done)
    assert {found.views for found in done.objects} == {1}
