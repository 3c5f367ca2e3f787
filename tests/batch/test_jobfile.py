"""Job files, globs and sweeps become named jobs, or are rejected in one line."""

import pickle
from pathlib import Path

import pytest

from recon.batch import jobfile
from recon.batch.jobfile import jobs_of_glob, read_jobs
from recon.errors import InputError

JOB = '[[job]]\nname = "a"\ncommand = "explore"\ninput = "village"\n'

HUGE = "".join(
    f'"{name}" = {[*range(1, 1001)]}\n'
    for name in ("map.min_count", "map.cell_size", "exploration.max_pairs")
)


def written(folder, text):
    path = folder / "jobs.toml"
    path.write_text(text)
    return path


def test_job_has_its_command_input_settings_and_seed(tmp_path):
    text = JOB + 'seed = 3\nsettings = { "map.cell_size" = 0.5, exploration = { max_pairs = 2 } }\n'
    (one,) = read_jobs(written(tmp_path, text))
    assert (one.name, one.job.kind, one.job.seed) == ("a", "explore", 3)
    assert one.job.settings.map.cell_size == 0.5
    assert one.job.settings.exploration.max_pairs == 2


def test_inputs_are_relative_to_the_folder_of_the_job_file(tmp_path):
    (tmp_path / "pair").mkdir()
    text = '[[job]]\ncommand = "reconstruct"\ninput = "pair"\n'
    (one,) = read_jobs(written(tmp_path, text))
    assert one.job.inputs == (tmp_path / "pair",)
    assert one.name == "pair"


def test_paths_among_the_arguments_are_relative_to_the_folder_of_the_job_file(tmp_path):
    text = (
        '[[job]]\ncommand = "disparity"\ninput = ["l.png", "r.png"]\n'
        'arguments = { calib = "calib.txt", truth = "/data/truth.pfm", truth_scale = 4 }\n'
    )
    (named,) = read_jobs(written(tmp_path, text))
    assert named.job.arguments == {
        "calib": tmp_path / "calib.txt",
        "truth": Path("/data/truth.pfm"),
        "truth_scale": 4.0,
    }


def test_shipped_scene_is_found_by_name(tmp_path):
    (one,) = read_jobs(written(tmp_path, JOB))
    assert one.job.resolved().inputs[0].name == "village.scene"


def test_missing_input_is_still_a_job(tmp_path):
    text = '[[job]]\ncommand = "reconstruct"\ninput = "nowhere"\n'
    assert len(read_jobs(written(tmp_path, text))) == 1


def test_glob_gives_one_job_per_match(tmp_path):
    for name in ("b", "a", ".hidden"):
        (tmp_path / "runs" / name).mkdir(parents=True)
    text = '[[job]]\nname = "all"\ncommand = "reconstruct"\ninput = "runs/*"\n'
    assert [one.name for one in read_jobs(written(tmp_path, text))] == ["all-a", "all-b"]
    found = jobs_of_glob(str(tmp_path / "runs" / "*"), "reconstruct")
    assert [one.name for one in found] == ["a", "b"]


@pytest.mark.parametrize("name", ["drive 1", "drive (2)", "höhe 中", "2024.05.01", "a#b", "[1]"])
def test_job_is_named_by_its_input_whatever_that_is_called(tmp_path, name):
    (tmp_path / "runs" / name).mkdir(parents=True)
    (found,) = jobs_of_glob(str(tmp_path / "runs" / "*"), "reconstruct")
    assert found.name == name
    (found,) = jobs_of_glob(str(tmp_path / "runs" / name), "reconstruct")
    assert found.job.inputs == (tmp_path / "runs" / name,)


def test_swept_path_is_no_folder_of_its_own(tmp_path):
    text = JOB + '[sweep]\n"recognition.catalogue" = ["a/b.toml", "none"]\n'
    names = [one.name for one in read_jobs(written(tmp_path, text))]
    assert names[0] == "a-recognition.catalogue=a_b.toml"


def test_sweep_covers_every_combination(tmp_path):
    text = JOB + '[sweep]\n"map.cell_size" = [1.0, 2.0]\nexploration.max_pairs = [1, 2, 3]\n'
    jobs = read_jobs(written(tmp_path, text))
    assert len({one.name for one in jobs}) == len(jobs) == 6
    assert jobs[1].name == "a-map.cell_size=1.0-exploration.max_pairs=2"
    assert dict(jobs[5].swept) == {"map.cell_size": 2.0, "exploration.max_pairs": 3}
    assert jobs[5].job.settings.map.cell_size == 2.0


def test_jobs_of_all_tables_count_together(tmp_path, monkeypatch):
    monkeypatch.setattr(jobfile, "MAX_JOBS", 3)
    text = JOB + JOB.replace('"a"', '"b"') + '[sweep]\n"map.cell_size" = [1, 2]\n'
    with pytest.raises(InputError, match="has more than 3 jobs"):
        read_jobs(written(tmp_path, text))
    assert len(read_jobs(written(tmp_path, text.replace(", 2", "")))) == 2


def test_jobs_survive_pickling(tmp_path):
    (one,) = read_jobs(written(tmp_path, JOB + 'settings = { "map.cell_size" = 0.5 }\n'))
    again = pickle.loads(pickle.dumps(one))
    assert again.job.resolved().settings == one.job.resolved().settings


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("", r"has no \[\[job\]\] table"),
        ("[[job]]\n", r"job 1 has no command, but a word"),
        ('[[job]]\ncommand = "fly"\ninput = "a"\n', "job 1: kind of job is 'fly'"),
        ('[[job]]\ncommand = "explore"\n', "input is None, but a path or a list"),
        ('[[job]]\ncommand = "explore"\ninput = 3\n', "input is 3"),
        (JOB + "colour = 1\n", "'colour' is unknown, but one of name"),
        (JOB + "seed = -1\n", "seed is -1"),
        (JOB + "seed = true\n", "seed is True"),
        (JOB + 'quality = "swift"\n', "quality is 'swift', but one of best, fast"),
        (JOB + 'settings = { "map.cellsize" = 1 }\n', "nearest known name is map.cell_size"),
        (JOB + 'settings = { "map.cell_size" = -1 }\n', "map.cell_size is -1"),
        (JOB + "settings = 3\n", "settings is 3, but a table"),
        (JOB + "arguments = [1]\n", r"arguments is \[1\], but a table"),
        (JOB + "arguments = { view = 1 }\n", "job 1: argument view is unknown to explore"),
        (JOB + "[sweep]\nmap = [1]\n", r"sweep: map is \[1\], but a table is needed"),
        (JOB + JOB, "2 jobs are named 'a'"),
        (JOB.replace('"a"', '"../a"'), r"jobs.toml: name is '../a'"),
        (JOB.replace('"a"', '"summary.json"'), "name is 'summary.json', but that of a new folder"),
        (JOB.replace('"a"', '""'), "name is '', but that of a new folder"),
        (JOB.replace('"a"', '"x.refined.json"'), "name is 'x.refined.json', but that of a new"),
        (JOB.replace('"a"', f'"{"é" * 101}"'), "name 'é+'... has 202 bytes, but at most 200"),
        (JOB.replace('"a"', "3"), "job 1: name is 3"),
        (JOB + "[sweep]\nmap.cell_size = 1\n", "sweep of map.cell_size is 1, but a list"),
        (JOB.replace("village", "no/*.scene"), "matches no file or folder"),
        (JOB.replace("village", "a**b"), "a[*]+b is not a pattern: "),
        (JOB.replace("village", ""), "input is '', but a path or a list"),
        (JOB + "[sweep]\n" + HUGE, "jobs.toml has more than 100000 jobs; split it"),
        ("jobs = 1\n", "'jobs' is unknown"),
        ("[[job]", "a TOML file is needed"),
    ],
)
def test_invalid_job_is_rejected_in_one_line(tmp_path, text, fault):
    with pytest.raises(InputError, match=fault) as error:
        read_jobs(written(tmp_path, text))
    assert "\n" not in str(error.value)
