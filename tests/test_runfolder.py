"""The run folder: complete or absent, rejected, resumed, overwritten."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from recon.errors import InputError, ReconError
from recon.manifest import RunPlan, digest, read_manifest
from recon.runfolder import RunFolder, check_flags


@pytest.fixture
def plan(tmp_path):
    scene = tmp_path / "a.scene"
    scene.write_text("world")
    return RunPlan(command="explore", settings_toml="a = 1\n", seed=0, inputs=(scene,))


def prepare(path, plan, overwrite=False, resume=False):
    return RunFolder.prepare(path, plan, overwrite=overwrite, resume=resume)


def finish(path, plan, **flags):
    run = prepare(path, plan, **flags)
    with run.opened():
        run.write_json("metrics.json", {"pairs": 3})
    return run


def test_manifest_describes_a_finished_run(tmp_path, plan):
    finish(tmp_path / "run", plan)
    manifest = read_manifest(tmp_path / "run")
    assert manifest["state"] == "finished"
    assert manifest["inputs"] == [{"name": "a.scene", "sha256": digest(plan.inputs[0])}]
    assert set(manifest["outputs"]) == {"metrics.json", "settings.toml"}
    assert manifest["outputs"]["metrics.json"] == digest(tmp_path / "run" / "metrics.json")


def test_existing_run_is_rejected_without_a_flag(tmp_path, plan):
    finish(tmp_path / "run", plan)
    with pytest.raises(InputError, match="give --overwrite, --resume, or another -o"):
        prepare(tmp_path / "run", plan)


def test_overwrite_empties_a_run_but_no_other_folder(tmp_path, plan):
    finish(tmp_path / "run", plan)
    (tmp_path / "run" / "old.txt").write_text("x")
    finish(tmp_path / "run", plan, overwrite=True)
    assert not (tmp_path / "run" / "old.txt").exists()
    assert [path.name for path in tmp_path.iterdir() if path.name[0] == "."] == []
    (tmp_path / "thesis").mkdir()
    (tmp_path / "thesis" / "only_copy.tex").write_text("x")
    with pytest.raises(InputError, match="is not a run folder"):
        prepare(tmp_path / "thesis", plan, overwrite=True)
    (tmp_path / "thesis" / "manifest.json").write_text('{"name": "a web app"}')
    with pytest.raises(InputError, match="was not written by recon"):
        prepare(tmp_path / "thesis", plan, overwrite=True)
    assert (tmp_path / "thesis" / "only_copy.tex").exists()


def test_resume_starts_finds_a_finished_run_or_rejects_changes(tmp_path, plan):
    assert not prepare(tmp_path / "run", plan, resume=True).is_finished
    finish(tmp_path / "run", plan)
    assert prepare(tmp_path / "run", plan, resume=True).is_finished
    other = RunPlan(command="explore", settings_toml="a = 2\n", seed=0, inputs=plan.inputs)
    with pytest.raises(InputError, match="made with different settings"):
        prepare(tmp_path / "run", other, resume=True)
    plan.inputs[0].write_text("another world")
    with pytest.raises(InputError, match="made with different inputs"):
        prepare(tmp_path / "run", plan, resume=True)


def test_invalid_input_leaves_no_folder_and_failure_leaves_its_reason(tmp_path, plan):
    with pytest.raises(InputError, match="bad"), prepare(tmp_path / "bad", plan).opened():
        raise InputError("bad")
    assert not (tmp_path / "bad").exists()
    with pytest.raises(ReconError), prepare(tmp_path / "fail", plan).opened():
        raise ReconError("out of luck")
    manifest = read_manifest(tmp_path / "fail")
    assert (manifest["state"], manifest["error"]) == ("failed", "out of luck")


def test_interrupted_run_keeps_its_partial_results(tmp_path, plan):
    run = prepare(tmp_path / "run", plan)

    def cut_short():
        with run.opened():
            (run.partial / "000001.npz").write_bytes(b"x")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        cut_short()
    assert read_manifest(tmp_path / "run")["state"] == "interrupted"
    again = prepare(tmp_path / "run", plan, resume=True)
    with again.opened():
        assert (again.partial / "000001.npz").exists()
    assert not (tmp_path / "run" / "partial").exists()


def test_folder_that_is_not_a_run_is_named(tmp_path):
    with pytest.raises(InputError, match="is not a run folder"):
        read_manifest(tmp_path)


def test_existing_run_is_kept_until_the_new_one_can_start(tmp_path, plan):
    finish(tmp_path / "run", plan)
    (tmp_path / "run" / "old.txt").write_text("x")
    run = prepare(tmp_path / "run", plan, overwrite=True)
    assert (tmp_path / "run" / "old.txt").exists()

    def fail():
        with run.opened():
            raise InputError("bad")

    with pytest.raises(InputError, match="bad"):
        fail()
    assert (tmp_path / "run" / "old.txt").exists()


def test_input_inside_the_run_folder_is_not_overwritten(tmp_path, plan):
    finish(tmp_path / "run", plan)
    inside = tmp_path / "run" / "left.png"
    inside.write_text("x")
    other = RunPlan(command="disparity", settings_toml="", seed=0, inputs=(inside,))
    with pytest.raises(InputError, match=r"left\.png lies in"):
        prepare(tmp_path / "run", other, overwrite=True)


def test_inputs_of_the_same_name_are_distinguished(tmp_path, plan):
    for side in ("a", "b"):
        (tmp_path / side).mkdir()
        (tmp_path / side / "x.png").write_text(side)
    inputs = (tmp_path / "a" / "x.png", tmp_path / "b" / "x.png")
    both = RunPlan(command="disparity", settings_toml="", seed=0, inputs=inputs)
    finish(tmp_path / "run", both)
    inputs[0].write_text("changed")
    with pytest.raises(InputError, match="different inputs"):
        prepare(tmp_path / "run", both, resume=True)


def fail_run(run, error):
    """Open a run and end it with an error."""

    def work():
        with run.opened():
            run.write_json("metrics.json", {"pairs": 4})
            raise error

    with pytest.raises(type(error)):
        work()


def pairs(path):
    return json.loads((path / "metrics.json").read_text())["pairs"]


@pytest.mark.parametrize("error", [OSError(28, "No space left"), InputError("x"), MemoryError()])
def test_earlier_run_survives_a_failed_replacement(tmp_path, plan, error):
    finish(tmp_path / "run", plan)
    fail_run(prepare(tmp_path / "run", plan, overwrite=True), error)
    assert pairs(tmp_path / "run") == 3
    assert read_manifest(tmp_path / "run")["state"] == "finished"
    assert [path.name for path in tmp_path.iterdir() if path.name[0] == "."] == []


def test_earlier_run_survives_a_disk_that_holds_no_other_folder(tmp_path, plan, monkeypatch):
    finish(tmp_path / "run", plan)
    run = prepare(tmp_path / "run", plan, overwrite=True)

    def full(path, **_):
        if path == run.path:
            raise OSError(28, "No space left", str(path))

    with monkeypatch.context() as patched:
        patched.setattr(Path, "mkdir", full)
        with pytest.raises(OSError, match="No space left"), run.opened():
            pass
    assert pairs(tmp_path / "run") == 3


def test_run_in_the_current_folder_is_replaced_like_any_other(tmp_path, plan, monkeypatch):
    finish(tmp_path / "run", plan)
    monkeypatch.chdir(tmp_path / "run")
    finish(Path(), plan, overwrite=True)
    assert pairs(tmp_path / "run") == 3
    assert {one.name for one in tmp_path.iterdir()} == {"run", "a.scene"}


def test_write_error_without_a_file_name_names_the_folder(tmp_path, plan):
    run = prepare(tmp_path / "run", plan)
    with pytest.raises(OSError, match=r"No space left.*run'$"), run.opened():
        raise OSError(28, "No space left")


def test_earlier_run_is_removed_only_after_a_resumed_replacement(tmp_path, plan):
    finish(tmp_path / "run", plan)
    fail_run(prepare(tmp_path / "run", plan, overwrite=True), KeyboardInterrupt())
    assert read_manifest(tmp_path / "run")["state"] == "interrupted"
    assert pairs(tmp_path / ".run.before") == 3
    finish(tmp_path / "run", plan, resume=True)
    assert not (tmp_path / ".run.before").exists()


def test_finished_one_of_two_earlier_runs_is_kept(tmp_path, plan):
    finish(tmp_path / "run", plan)
    fail_run(prepare(tmp_path / "run", plan, overwrite=True), KeyboardInterrupt())
    fail_run(prepare(tmp_path / "run", plan, overwrite=True), OSError(28, "No space left"))
    assert pairs(tmp_path / "run") == 3


def test_two_processes_cannot_write_the_same_run(tmp_path, plan):
    first, second = (prepare(tmp_path / "run", plan) for _ in range(2))

    def both():
        with first.opened(), second.opened():
            pass

    with pytest.raises(InputError, match="is being written by another process"):
        both()
    assert not (tmp_path / ".run.lock").exists()


def test_lock_of_a_dead_process_is_taken_over(tmp_path, plan):
    (tmp_path / ".run.lock").touch()
    finish(tmp_path / "run", plan)
    script = (
        "import os, sys, pathlib; from recon.locks import locked\n"
        "with locked(pathlib.Path(sys.argv[1]), 'busy'): os._exit(1)"
    )
    lock = tmp_path / ".run.lock"
    subprocess.run([sys.executable, "-c", script, str(tmp_path / "run")], check=False)
    assert lock.exists()
    finish(tmp_path / "run", plan, overwrite=True)
    assert not lock.exists()


def test_temporary_files_of_a_killed_process_are_removed(tmp_path, plan):
    fail_run(prepare(tmp_path / "run", plan), KeyboardInterrupt())
    (tmp_path / "run" / ".4711-0123abcd-map.npz").write_text("half")
    (tmp_path / "run" / ".mine").write_text("x")
    finish(tmp_path / "run", plan, resume=True)
    assert not (tmp_path / "run" / ".4711-0123abcd-map.npz").exists()
    assert (tmp_path / "run" / ".mine").exists()


def test_folder_that_cannot_hold_a_run_is_named_in_the_error(plan):
    folder = prepare(Path("/proc/run"), plan)
    with pytest.raises(OSError, match="No such file") as error, folder.opened():
        pass
    assert error.value.filename == "/proc"


@pytest.mark.parametrize("below", ["run", "deep/run"])
def test_folder_below_a_file_is_named_with_what_is_needed(tmp_path, below):
    (tmp_path / "notes").touch()
    with pytest.raises(InputError) as error:
        check_flags(tmp_path / "notes" / below, overwrite=False, resume=False)
    file = tmp_path / "notes"
    assert f"output is {file / below}, but {file} is not a folder" in str(error.value)


def test_folder_below_missing_ones_is_accepted(tmp_path):
    check_flags(tmp_path / "not" / "yet" / "run", overwrite=False, resume=False)
