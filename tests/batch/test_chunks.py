"""Recordings cut into jobs give the map of one run, byte for byte, with any scheduler."""

import json

import numpy as np
import pytest

from recon.batch.batch import run_batch
from recon.batch.chunks import MERGED
from recon.batch.jobfile import jobs_of_glob
from recon.cli import main
from recon.errors import InputError
from recon.exports.partitions.partitioned import PartitionedMap
from recon.exports.ply import read_mesh
from recon.sequences import images
from recon.sequences.open import open_sequence
from recon.sequences.refined import Refined, read_refined, refine
from recon.settings import SequenceSettings
from tests.recordings import contents, render_drive
from tests.schedulers import Sent

pytestmark = pytest.mark.usefixtures("without_figures")

SETTINGS = ["--quality", "fast", "--set", "map.partition_size=64"]
JOB = """
[[job]]
name = "wall"
command = "reconstruct"
input = "drive"
quality = "fast"
settings = { "map.partition_size" = 64, "sequence.only_confirmed" = true, "surface.mesh" = true }
"""
SHARED = ("cloud.ply", "objects.json", "trajectory.txt", "dense.ply")


@pytest.fixture(scope="module")
def drive(tmp_path_factory):
    return render_drive(tmp_path_factory.mktemp("batch"), 5)


@pytest.fixture(scope="module")
def whole(drive):
    run = drive.parent / "whole"
    given = ["--chunk", "5", "--set", "sequence.only_confirmed=true", "--mesh", "-q"]
    assert main(["reconstruct", str(drive), "-o", str(run), *SETTINGS, *given]) == 0
    return run


def test_chunked_jobs_merge_to_the_map_of_one_run(drive, whole, tmp_path):
    (drive.parent / "jobs.toml").write_text(JOB)
    given = ["batch", str(drive.parent / "jobs.toml"), "-o", str(tmp_path / "out"), "--chunk", "2"]
    assert main([*given, "-j", "2", "-q"]) == 0
    jobs = json.loads((tmp_path / "out" / "summary.json").read_text())["jobs"]
    assert [one["name"] for one in jobs] == ["wall-000000", "wall-000002", "wall-000004", MERGED]
    merged = tmp_path / "out" / MERGED
    assert contents(merged / "map.parquet") == contents(whole / "map.parquet")
    for name in SHARED:
        assert (merged / name).read_bytes() == (whole / name).read_bytes(), name
    meshes = [read_mesh(run / "mesh.ply") for run in (whole, merged)]
    places = [{one.tobytes() for one in mesh.vertices} for mesh in meshes]
    assert len(places[0] & places[1]) > 0.9 * len(places[0] | places[1]) > 5
    numbers = [json.loads((run / "metrics.json").read_text()) for run in (whole, merged)]
    for name in ("dense_share", "dense_confirmed_share", "voxel", "num_dense_points"):
        assert numbers[0][name] == numbers[1][name], name
    assert main([*given, "-j", "1", "-q", "--resume"]) == 0


def test_map_of_two_recordings_counts_their_views_separately(drive, tmp_path):
    jobs = [*jobs_of_glob(str(drive), "reconstruct")] * 2
    one, two = (tmp_path / name for name in ("one", "two"))
    from dataclasses import replace

    names = [replace(job, name=f"d{number}") for number, job in enumerate(jobs)]
    run_batch(names[:1], one, Sent(), chunk=5)
    run_batch(names, two, Sent(), chunk=5)
    single, double = (PartitionedMap(out / MERGED / "map.parquet") for out in (one, two))
    assert double.num_points == 2 * single.num_points > 100
    assert np.array_equal(double.occupied(2).num_views, 2 * single.occupied(1).num_views)


def test_missing_recording_is_a_failed_job_and_nothing_is_merged(tmp_path):
    jobs = jobs_of_glob(str(tmp_path / "nowhere"), "reconstruct")
    report = run_batch(jobs, tmp_path / "out", Sent(), chunk=2)
    assert [one.state for one in report.outcomes] == ["failed"]
    assert "does not exist" in report.outcomes[0].error


def test_chunks_are_for_reconstructions_without_a_sweep(tmp_path):
    with pytest.raises(InputError, match="chunks are for reconstruct"):
        run_batch(jobs_of_glob("village", "explore"), tmp_path / "out", Sent(), chunk=2)
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("poses", ["given", "estimated"])
def test_part_read_with_a_record_equals_the_whole_and_reads_no_earlier_images(
    drive, poses, tmp_path, monkeypatch
):
    settings = SequenceSettings(poses=poses)
    source = open_sequence(drive, settings)
    whole = list(source)
    refine(source).write(tmp_path / "refined.json")
    again = open_sequence(drive, settings, read_refined(tmp_path / "refined.json"))
    read = []
    decode = images.read_pixels

    def recorded(path, *given):
        read.append(path.stem)
        return decode(path, *given)

    monkeypatch.setattr(images, "read_pixels", recorded)
    part = list(again[3:5])
    assert set(read) == {pair.name for pair in part}
    for own, other in zip(whole[3:], part, strict=True):
        assert np.array_equal(own.right, other.right)
        assert np.array_equal(own.T_world_left, other.T_world_left)


@pytest.mark.parametrize(
    "text", ["[]", "{}", '{"row_residual_px": [0], "disparity_residual_px": [], "poses": {}}']
)
def test_damaged_record_is_rejected(text, tmp_path):
    (tmp_path / "refined.json").write_text(text)
    with pytest.raises(InputError, match="not the record of a recording"):
        read_refined(tmp_path / "refined.json")


def test_part_beyond_the_recording_is_rejected(drive, tmp_path):
    from recon.runs.execute import execute
    from recon.runs.job import Job

    job = Job(kind="reconstruct", inputs=(drive,), arguments={"part": [3, 9]})
    with pytest.raises(InputError, match="part ends at 9, but the recording has 5 pairs"):
        execute(job, tmp_path / "run")
    with pytest.raises(InputError, match="non-empty span"):
        execute(
            Job(kind="reconstruct", inputs=(drive,), arguments={"part": [3, 3]}), tmp_path / "r"
        )


def test_record_round_trip(tmp_path):
    from recon.sequences.calibration.row_error import Field, Residual

    record = Refined(
        residual=Residual(row=Field(coefficients=np.arange(6) / 7)), poses={"a": np.eye(4)}
    )
    record.write(tmp_path / "refined.json")
    again = read_refined(tmp_path / "refined.json")
    assert np.array_equal(again.residual.row.coefficients, np.arange(6) / 7)
    assert np.array_equal(again.poses["a"], np.eye(4))
