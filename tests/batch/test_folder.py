"""The folder of a batch: earlier results and inputs outlive whatever happens to a new batch."""

import json

import pytest

from recon.batch.batch import run_batch
from recon.batch.jobfile import NamedJob, jobs_of_glob
from recon.batch.worker import Outcome
from recon.cli import main
from recon.errors import InputError
from recon.runs.job import Job

JOB = NamedJob(name="a", job=Job(kind="explore", inputs=("village",)))


class Ending:
    """A scheduler whose jobs end in a state, after writing something, or that raises."""

    def __init__(self, folder, state="done", error=None):
        self.folder, self.state, self.error = folder, state, error

    def outcomes(self, calls):
        if self.error:
            raise self.error
        for name, _ in calls:
            (self.folder / name).mkdir(exist_ok=True)
            (self.folder / name / "made").write_text(self.state)
            yield Outcome(name=name, state=self.state)


def end(folder, state="done", error=None, **flags):
    """Run a batch of one job to its end, and write its summary."""
    report = run_batch([JOB], folder, Ending(folder, state, error), **flags)
    document = report.as_json() | {"num_failed": report.num_failed}
    (folder / "summary.json").write_text(json.dumps(document))


@pytest.mark.parametrize("error", [InputError("no scheduler"), OSError(28, "No space left")])
def test_earlier_batch_survives_one_that_does_not_begin(tmp_path, error):
    end(tmp_path / "out")
    before = (tmp_path / "out" / "summary.json").read_text()
    with pytest.raises(type(error)):
        end(tmp_path / "out", error=error, overwrite=True)
    assert (tmp_path / "out" / "summary.json").read_text() == before
    assert [one.name for one in tmp_path.iterdir()] == ["out"]


def test_batch_that_does_not_begin_leaves_nothing(tmp_path):
    with pytest.raises(InputError):
        end(tmp_path / "out", error=InputError("no scheduler"))
    assert not list(tmp_path.iterdir())


def test_earlier_batch_is_kept_until_no_job_of_the_new_one_fails(tmp_path):
    kept = tmp_path / ".out.before" / "a" / "made"
    end(tmp_path / "out")
    end(tmp_path / "out", "failed", overwrite=True)
    assert kept.read_text() == "done"
    end(tmp_path / "out", "failed", overwrite=True)  # of two, the one without a failed job is kept
    assert kept.read_text() == "done"
    end(tmp_path / "out", resume=True)
    assert [one.name for one in tmp_path.iterdir()] == ["out"]


def test_folder_that_contains_an_input_is_not_replaced(tmp_path, monkeypatch):
    end(tmp_path / "out")
    jobs = jobs_of_glob(str(tmp_path / "out" / "*" / "made"), "recognise")
    with pytest.raises(InputError, match=r"made lies in .* and would be deleted with it"):
        run_batch(jobs, tmp_path / "out", Ending(tmp_path / "out"), overwrite=True)
    monkeypatch.chdir(tmp_path / "out")
    (tmp_path / "out" / "jobs.toml").write_text('[[job]]\ncommand = "explore"\ninput = "village"\n')
    assert main(["batch", "jobs.toml", "-o", ".", "--overwrite", "-q"]) == 2
    assert (tmp_path / "out" / "jobs.toml").exists()


def test_folder_may_be_the_current_one(tmp_path, monkeypatch):
    end(tmp_path / "out", "failed")
    monkeypatch.chdir(tmp_path / "out")
    run_batch([JOB], type(tmp_path)(), Ending(tmp_path / "out"), resume=True)
    run_batch([JOB], type(tmp_path)(), Ending(tmp_path / "out"), overwrite=True)
    assert (tmp_path / "out" / "a" / "made").read_text() == "done"
    assert [one.name for one in tmp_path.iterdir()] == ["out"]


@pytest.mark.parametrize(
    ("options", "fault"),
    [
        (["--metric", "num_pairs"], "--metric is for a sweep, but no setting is swept"),
        (["--chunk", "2"], "village is explore, but chunks are for reconstruct"),
    ],
)
def test_option_that_does_not_suit_the_jobs_is_rejected_in_a_dry_run(options, fault, capsys):
    assert main(["batch", "village", "--command", "explore", "--dry-run", *options]) == 2
    assert fault in capsys.readouterr().err


def test_empty_pattern_is_not_the_current_folder(capsys):
    assert main(["batch", "", "--command", "explore", "--dry-run"]) == 2
    assert "it is empty" in capsys.readouterr().err
