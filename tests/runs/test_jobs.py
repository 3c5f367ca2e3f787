"""Jobs: identity, events while running, and results."""

import ast
import hashlib
import inspect
import json
import pickle
from pathlib import Path

import cv2
import numpy as np
import pytest

import recon
from recon.cli import main
from recon.cli.jobs import counted
from recon.notices import notify
from recon.runs import disparity, evaluate
from recon.runs.job import KINDS

PAIR = Path(__file__).parents[2] / "data" / "motorcycle"
FAST = recon.Settings.of(quality="fast", keep=500)


@pytest.fixture(scope="module")
def small_pair(tmp_path_factory):
    """A crop of the Motorcycle pair with its truth."""
    folder = tmp_path_factory.mktemp("pairs") / "small"
    folder.mkdir()
    part = np.s_[150:270, 250:490]
    for side in ("left", "right"):
        cv2.imwrite(str(folder / f"{side}.png"), cv2.imread(str(PAIR / f"{side}.png"))[part])
    truth = cv2.imread(str(PAIR / "disp_left.pfm"), cv2.IMREAD_UNCHANGED)[part]
    cv2.imwrite(str(folder / "disp_left.pfm"), truth)
    return folder


def matching(**changes):
    values = {"kind": "disparity", "inputs": (PAIR / "left.png", PAIR / "right.png")}
    return recon.Job(**(values | {"settings": FAST} | changes))


@pytest.mark.parametrize(
    "changes",
    [
        {"kind": "evaluate", "inputs": (PAIR,)},
        {"inputs": (PAIR / "right.png", PAIR / "left.png")},
        {"arguments": {"truth_scale": 2.0}},
        {"arguments": {"truth": PAIR / "disp_left.pfm"}},
        {"settings": recon.Settings.of(quality="fast", keep=501)},
        {"seed": 1},
    ],
)
def test_identity_covers_everything_that_affects_the_result(changes):
    same, other = matching().identity(), matching(**changes).identity()
    assert same == matching().identity()
    assert same != other


def test_identity_covers_the_content_of_catalogue_and_model(tmp_path):
    catalogue = tmp_path / "kinds.toml"
    catalogue.write_text("a = 1")
    job = matching(settings=recon.Settings.of(catalogue=str(catalogue)))
    before = job.identity()
    catalogue.write_text("a = 2")
    assert job.identity() != before


@pytest.mark.parametrize("kind", KINDS.names())
def test_job_survives_pickling(kind):
    job = recon.Job(kind=kind, inputs=("a",), settings=FAST, seed=3)
    again = pickle.loads(pickle.dumps(job))
    assert again == job
    assert again.settings.matching.searching((3, 9)).max_disparity == 9


def test_stages_steps_and_progress_are_reported_and_add_up(tmp_path):
    stages, steps, progress = [], [], []
    events = recon.Events(
        on_stage=stages.append, on_step=steps.append, on_progress=lambda *now: progress.append(now)
    )
    job = recon.Job(kind="reconstruct", inputs=(PAIR,), settings=FAST)
    report = recon.execute(job, tmp_path / "run", events)
    seconds = dict(report["seconds"])
    total = seconds.pop("total")
    assert {"reading", "stereo", "map", "recognise", "figures", "write"} <= set(seconds)
    assert sum(seconds.values()) == pytest.approx(total, rel=1e-9)
    assert {"stereo", "map", "recognise", "figures", "write"} <= set(stages)
    assert [step.number for step in steps] == [0]
    assert progress == [(1, 1)]
    assert report.run == tmp_path / "run"
    assert len(report.objects) == len(report["objects"])
    json.dumps(report.as_json(), allow_nan=False)


def test_cancelled_job_ends_as_interrupted(tmp_path):
    job = recon.Job(kind="reconstruct", inputs=(PAIR,), settings=FAST)
    with pytest.raises(recon.Cancelled):
        recon.execute(job, tmp_path / "run", recon.Events(is_cancelled=lambda: True))
    manifest = json.loads((tmp_path / "run" / "manifest.json").read_text())
    assert manifest["state"] == "interrupted"


def test_finished_evaluation_is_not_recomputed(small_pair, tmp_path, capsys, monkeypatch):
    argv = ["evaluate", str(small_pair), "--quality", "fast", "--keep", "500", "--json"]
    argv += ["-o", str(tmp_path / "run"), "--resume"]
    assert main(argv) == 0
    first = json.loads(capsys.readouterr().out)
    monkeypatch.setattr(evaluate.Trial, "row", lambda self: pytest.fail("computed again"))
    assert main(argv) == 0
    assert json.loads(capsys.readouterr().out) == first


@pytest.mark.parametrize("other", [["--matcher", "sgbm"], ["--truth-scale", "2"], ["--seed", "4"]])
def test_resuming_a_different_evaluation_is_rejected(small_pair, tmp_path, capsys, other):
    argv = ["evaluate", str(small_pair), "--quality", "fast", "--keep", "500", "-q"]
    argv += ["-o", str(tmp_path / "run"), "--resume"]
    assert main(argv) == 0
    assert main([*argv, *other]) == 2
    assert "was made with different" in capsys.readouterr().err


def test_identity_covers_the_number_of_worlds(tmp_path):
    def worlds(number):
        return recon.Job(kind="worlds", arguments={"worlds": number}).plan()

    assert worlds(1).identity() != worlds(2).identity()


def test_digests_match_sha256sum(tmp_path):
    recon.execute(matching(), tmp_path / "run")
    manifest = json.loads((tmp_path / "run" / "manifest.json").read_text())
    for name, digest in manifest["outputs"].items():
        assert digest == hashlib.sha256((tmp_path / "run" / name).read_bytes()).hexdigest()
    assert manifest["inputs"][0]["sha256"] == (
        hashlib.sha256((PAIR / "left.png").read_bytes()).hexdigest()
    )


def test_notice_is_one_line_and_one_entry(tmp_path, capsys, monkeypatch):
    measure = disparity.measure

    def measure_with_notice(*given):
        notify("rows-differ", "rows differ by 2 pixels")
        return measure(*given)

    monkeypatch.setattr(disparity, "measure", measure_with_notice)
    argv = ["disparity", str(PAIR / "left.png"), str(PAIR / "right.png"), "--quality", "fast"]
    argv += ["--max-disparity", "70", "--json", "-o", str(tmp_path / "run")]
    assert main(argv) == 0
    said = capsys.readouterr()
    warnings = [{"code": "rows-differ", "text": "rows differ by 2 pixels"}]
    assert json.loads(said.out)["warnings"] == warnings
    assert json.loads((tmp_path / "run" / "metrics.json").read_text())["warnings"] == warnings
    assert said.err.count("rows differ") == 1


def test_counts_use_singular_and_plural():
    assert [counted(number, "pair") for number in (0, 1, 2)] == ["0 pairs", "1 pair", "2 pairs"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"matcher": "sgbm"}, "argument matcher is unknown to evaluate; the nearest is matchers"),
        ({"matchers": 3}, "evaluate: matchers is 3, but a list of texts is needed"),
        ({"truth_scale": "much"}, "truth_scale is 'much', but a number > 0"),
        ({"truth_scale": float("nan")}, "truth_scale is nan"),
    ],
)
def test_invalid_arguments_of_a_kind_are_named(arguments, message):
    with pytest.raises(recon.InputError, match=message):
        recon.Job(kind="evaluate", inputs=PAIR, arguments=arguments).resolved()


def test_arguments_are_converted_for_their_kind():
    job = recon.Job(kind="evaluate", inputs=str(PAIR), arguments={"matchers": "sgbm"}).resolved()
    assert job.inputs == (PAIR,)
    assert job.arguments == {"matchers": ("sgbm",)}


@pytest.mark.parametrize(
    ("kind", "inputs", "message"),
    [
        ("explore", (), "explore has 0 inputs, but 1 are needed"),
        ("explore", ("a", "b"), "explore has 2 inputs, but 1 are needed"),
        ("localise", ("a",), "localise has 1 inputs, but 2 are needed"),
        ("merge", (), "merge has 0 inputs, but 1 or more are needed"),
        ("worlds", ("a",), "worlds has 1 inputs, but 0 are needed"),
    ],
)
def test_wrong_number_of_inputs_is_rejected(kind, inputs, message):
    with pytest.raises(recon.InputError, match=message):
        recon.Job(kind=kind, inputs=inputs).resolved()


def requested_arguments(source):
    """Find the names of the arguments that a source reads from its job."""
    found = set()
    for node in ast.walk(ast.parse(source)):
        match node:
            case ast.Subscript(value=ast.Attribute(attr="arguments"), slice=ast.Constant(name)):
                found.add(name)
            case ast.Call(
                func=ast.Attribute(attr="get", value=ast.Attribute(attr="arguments")),
                args=[ast.Constant(name), *_],
            ):
                found.add(name)
    return found


@pytest.mark.parametrize("kind", KINDS.names())
def test_kind_declares_the_arguments_it_uses(kind):
    loaded = KINDS.load(kind)
    assert requested_arguments(inspect.getsource(inspect.getmodule(loaded.run))) <= set(
        loaded.takes
    )


def test_use_of_arguments_is_detected():
    assert requested_arguments("job.arguments.get('a', 1), job.arguments['b'], other.get('c')") == {
        "a",
        "b",
    }
