"""Jobs: what makes one what it is, what it tells while it runs, and what is left of it."""

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
    """A part of the Motorcycle pair with its truth."""
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
def test_everything_that_decides_is_part_of_the_identity(changes):
    same, other = matching().identity(), matching(**changes).identity()
    assert same == matching().identity()
    assert same != other


def test_the_content_of_a_catalogue_or_model_is_part_of_the_identity(tmp_path):
    catalogue = tmp_path / "kinds.toml"
    catalogue.write_text("a = 1")
    job = matching(settings=recon.Settings.of(catalogue=str(catalogue)))
    before = job.identity()
    catalogue.write_text("a = 2")
    assert job.identity() != before


@pytest.mark.parametrize("kind", KINDS.names())
def test_a_job_travels(kind):
    job = recon.Job(kind=kind, inputs=("a",), settings=FAST, seed=3)
    again = pickle.loads(pickle.dumps(job))
    assert again == job
    assert again.settings.matching.searching((3, 9)).max_disparity == 9


def test_stages_add_up_and_are_told_with_steps_and_progress(tmp_path):
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


def test_a_cancelled_job_ends_and_says_so(tmp_path):
    job = recon.Job(kind="reconstruct", inputs=(PAIR,), settings=FAST)
    with pytest.raises(recon.Cancelled):
        recon.execute(job, tmp_path / "run", recon.Events(is_cancelled=lambda: True))
    manifest = json.loads((tmp_path / "run" / "manifest.json").read_text())
    assert manifest["state"] == "interrupted"


def test_a_finished_evaluation_is_not_done_again(small_pair, tmp_path, capsys, monkeypatch):
    argv = ["evaluate", str(small_pair), "--quality", "fast", "--keep", "500", "--json"]
    argv += ["-o", str(tmp_path / "run"), "--resume"]
    assert main(argv) == 0
    first = json.loads(capsys.readouterr().out)
    monkeypatch.setattr(evaluate.Trial, "row", lambda self: pytest.fail("computed again"))
    assert main(argv) == 0
    assert json.loads(capsys.readouterr().out) == first


@pytest.mark.parametrize("other", [["--matcher", "sgbm"], ["--truth-scale", "2"], ["--seed", "4"]])
def test_another_evaluation_is_not_taken_for_the_same(small_pair, tmp_path, capsys, other):
    argv = ["evaluate", str(small_pair), "--quality", "fast", "--keep", "500", "-q"]
    argv += ["-o", str(tmp_path / "run"), "--resume"]
    assert main(argv) == 0
    assert main([*argv, *other]) == 2
    assert "was made with different" in capsys.readouterr().err


def test_another_number_of_worlds_is_not_taken_for_the_same(tmp_path):
    def worlds(number):
        return recon.Job(kind="worlds", arguments={"worlds": number}).plan()

    assert worlds(1).identity() != worlds(2).identity()


def test_digests_are_those_that_sha256sum_prints(tmp_path):
    recon.execute(matching(), tmp_path / "run")
    manifest = json.loads((tmp_path / "run" / "manifest.json").read_text())
    for name, digest in manifest["outputs"].items():
        assert digest == hashlib.sha256((tmp_path / "run" / name).read_bytes()).hexdigest()
    assert manifest["inputs"][0]["sha256"] == (
        hashlib.sha256((PAIR / "left.png").read_bytes()).hexdigest()
    )


def test_what_is_noticed_is_one_line_and_an_entry(tmp_path, capsys, monkeypatch):
    measure = disparity.measure

    def noticing(*given):
        notify("rows-differ", "rows differ by 2 pixels")
        return measure(*given)

    monkeypatch.setattr(disparity, "measure", noticing)
    argv = ["disparity", str(PAIR / "left.png"), str(PAIR / "right.png"), "--quality", "fast"]
    argv += ["--max-disparity", "70", "--json", "-o", str(tmp_path / "run")]
    assert main(argv) == 0
    said = capsys.readouterr()
    warnings = [{"code": "rows-differ", "text": "rows differ by 2 pixels"}]
    assert json.loads(said.out)["warnings"] == warnings
    assert json.loads((tmp_path / "run" / "metrics.json").read_text())["warnings"] == warnings
    assert said.err.count("rows differ") == 1


def test_one_pair_is_not_some_pairs():
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
def test_arguments_that_a_kind_does_not_take_are_named(arguments, message):
    with pytest.raises(recon.InputError, match=message):
        recon.Job(kind="evaluate", inputs=PAIR, arguments=arguments).resolved()


def test_arguments_come_as_the_kind_takes_them():
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
def test_number_of_inputs_is_that_of_the_kind(kind, inputs, message):
    with pytest.raises(recon.InputError, match=message):
        recon.Job(kind=kind, inputs=inputs).resolved()


def asked(source):
    """Names of the arguments that a source takes out of its job."""
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
def test_a_kind_takes_what_it_asks_for(kind):
    loaded = KINDS.load(kind)
    assert asked(inspect.getsource(inspect.getmodule(loaded.run))) <= set(loaded.takes)


def test_what_is_asked_for_is_seen():
    assert asked("job.arguments.get('a', 1), job.arguments['b'], other.get('c')") == {"a", "b"}
