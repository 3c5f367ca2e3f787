"""Every block of code in the pages: run where stand-ins are cheap, else read as commands."""

import re
import shlex
from pathlib import Path

import click
import numpy as np
import pytest

import recon
from recon.cli import main
from recon.cli.main import program
from recon.exports import write
from recon.records import Mesh, PointCloud
from recon.world.scene import read_scene
from tests.exports.maps import a_cloud, a_map
from tests.sequences.recordings import write_folder

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
BLOCK = re.compile(r"^```(\w*)\n(.*?)^```", re.M | re.S)

FOLLOWED = {
    "README.md": "test_readme",
    "docs/start.md": "test_pages",
    "docs/hour.md": "test_pages",
    "docs/concepts/occupancy.md": "test_pages",
    "docs/plugin/README.md": "test_plugin_example",
    "docs/howto/large.md": "tests of partitioned maps and of chunks, on smaller data",
    "docs/howto/localise.md": "tests of localisation, which render what it needs",
}
"""Pages that other tests follow from the first line to the last."""
READ_ONLY = {
    "reconstruct table": "needs images of a table; the first hour does the same",
    "recognise runs/table": "follows on that",
    "learn mug1.ply": "follows on that",
    "batch": "hours of work; tests of batches run smaller ones",
    "reconstruct recording.bag": "needs a bag; tests of readers write some",
    "reconstruct drive": "needs a drive; the first hour reconstructs",
    "calibrate boards/left": "needs boards; tests of calibration draw some",
    "rectify left.png": "follows on that",
    "explore own.scene": "minutes of work; the scene itself is read here",
    "simulate own.scene": "a server",
    "explore village --dense": "a minute of work; tests of surfaces explore less",
    "mesh runs/drive": "follows on a drive; tests of surfaces make such meshes",
    "render cottage": "a minute of work; the first hour renders it smaller",
    "reconstruct ring": "follows on that",
    "evaluate --surface runs/ring": "follows on that",
    "render village": "a minute of work; the first hour renders",
    "localise runs/drive": "needs two recordings of a place; tests of localisation render them",
    "explore village --set motion": "minutes of work; tests of localisation explore",
}
"""Beginnings of commands that are read and not run, each with its reason."""


def blocks(page):
    return BLOCK.findall(page.read_text())


def commands():
    """(page, words) of every command in the pages."""
    for page in PAGES:
        for language, text in blocks(page):
            for line in text.splitlines() if language == "console" else ():
                name = page.relative_to(ROOT).as_posix()
                yield name, shlex.split(line.partition(" #")[0].removeprefix(".venv/bin/"))


def understood(words):
    """Read words as the program does, without doing what they say."""
    command: click.Command = program
    context = click.Context(program, info_name="recon")
    while isinstance(command, click.Group):
        name, command, words = command.resolve_command(context, words)
    command.make_context(name, list(words), parent=context)


def test_every_command_of_the_pages_is_one_that_the_program_knows():
    found = list(commands())
    assert len(found) > 30
    for page, words in found:
        assert words[0] == "recon", page
        understood(words[1:])
    with pytest.raises(click.NoSuchOption):
        understood(["explore", "village", "--no-such-option"])
    with pytest.raises(click.UsageError):
        understood(["explode", "village"])


def test_no_command_hides_in_a_block_without_a_language():
    hidden = [text for page in PAGES for language, text in blocks(page) if not language]
    assert [text for text in hidden if text.startswith(("recon ", "import "))] == []


def test_what_is_only_read_has_a_reason_and_is_there():
    texts = [" ".join(words[1:]) for _, words in commands()]
    unused = [begin for begin in READ_ONLY if not any(t.startswith(begin) for t in texts)]
    assert unused == []


@pytest.fixture(scope="module")
def bench(tmp_path_factory):
    """A folder that holds small stand-ins for what the pages speak of."""
    folder = tmp_path_factory.mktemp("bench")
    (folder / "runs/walk").mkdir(parents=True)
    a_map().save(folder / "runs/walk/map.npz")
    write(a_cloud(), folder / "runs/walk/cloud.ply")
    utm = np.array([[500050.0, 20.0, -5400050.0], [500060.0, 21.0, -5400060.0]])
    write(PointCloud(points=utm), folder / "scan.laz")
    triangle = Mesh(vertices=np.eye(3), triangles=np.array([[0, 1, 2]], np.int32))
    write(triangle, folder / "part.stl")
    (folder / "table.txt").write_text("0.1 1 2 3 9\n0.2 4 5 6 9\n")
    write_folder(folder / "drive")
    return folder


def test_commands_of_the_pages_work(bench, monkeypatch):
    monkeypatch.chdir(bench)
    done = 0
    for page, words in commands():
        text = " ".join(words[1:])
        if page not in FOLLOWED and not any(text.startswith(begin) for begin in READ_ONLY):
            assert main(words[1:]) == 0, (page, text)
            done += 1
    assert done >= 7
    assert len(recon.read("scan.ply")) == 2
    assert sorted(recon.read("table.parquet").attributes) == ["time"]


def test_python_of_the_pages_works(bench, monkeypatch):
    monkeypatch.chdir(bench)
    ran = 0
    for page in PAGES:
        for language, text in blocks(page):
            if language == "python" and page.relative_to(ROOT).as_posix() not in FOLLOWED:
                exec(compile(text, page.name, "exec"), {})
                ran += 1
    assert ran >= 1


def test_the_scene_of_the_page_is_a_scene(tmp_path):
    (text,) = (text for _, text in blocks(ROOT / "docs/howto/scene.md") if "# Shader" in text)
    (tmp_path / "own.scene").write_text(text)
    assert len(read_scene(tmp_path / "own.scene").visuals) == 2


def test_the_jobs_of_the_page_are_jobs(bench, monkeypatch, capsys):
    monkeypatch.chdir(bench)
    (text,) = (text for kind, text in blocks(ROOT / "docs/howto/cluster.md") if kind == "toml")
    Path("jobs.toml").write_text(text)
    write_folder(bench / "recordings" / "first")
    assert main(["batch", "jobs.toml", "--dry-run"]) == 0
    assert "drives" in capsys.readouterr().out
