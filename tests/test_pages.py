"""The pages are tested line by line, each in a folder with small stand-ins."""

import json
import re
import shlex
from contextlib import contextmanager
from pathlib import Path

import click
import pytest

import recon
from recon.cli import main
from recon.cli.main import program
from recon.world.scene import read_scene
from tests import stand_ins
from tests.app.conftest import served
from tests.recordings import SIZE
from tests.schedulers import Sent
from tests.stand_ins import DOCS, blocks

PREPARED = {
    "start.md": None,
    "concepts/occupancy.md": None,
    "howto/catalogue.md": stand_ins.mugs,
    "howto/cluster.md": stand_ins.jobs,
    "howto/headless.md": None,
    "howto/large.md": stand_ins.drives,
    "howto/localise.md": stand_ins.places,
    "howto/recording.md": stand_ins.recordings,
    "howto/rig.md": stand_ins.boards,
    "howto/scene.md": stand_ins.scene,
    "howto/surfaces.md": stand_ins.drive_run,
}
"""Pages, and the functions that write the files they need."""
ELSEWHERE = {
    "hour.md": "below, with what it must leave",
    "howto/programs.md": "below, with what it must leave",
    "plugin/README.md": "test_plugin_example",
}
REDUCED = {
    "explore own.scene": ["--max-pairs", "2"],
    "explore village": ["--max-pairs", "2", *SIZE],
    "render village --views ring:20": SIZE,
    "render cottage --views ring:20": SIZE,
    "batch jobs.toml --scheduler": ["--resume", "-j", "1"],
}
"""Prefixes of commands, and the options that reduce their work."""
SUBSTITUTES = {
    "/cam0/image_raw": "/stereo/left/image_rect",
    "/cam1/image_raw": "/stereo/right/image_rect",
    "/shared/runs/all": "runs/all",
}


def pages():
    return {page.relative_to(DOCS).as_posix(): page for page in sorted(DOCS.rglob("*.md"))}


def commands(text):
    return [shlex.split(line.partition(" #")[0]) for line in text.splitlines()]


def reduced(words):
    """Adapt the words of a command to the stand-ins."""
    line = " ".join(words)
    extra = next((words for begin, words in REDUCED.items() if line.startswith(begin)), [])
    return [SUBSTITUTES.get(word, word) for word in words] + extra


@contextmanager
def with_local_cluster(words):
    """Replace any Dask scheduler in the words of a command by one in this process."""
    if "--scheduler" not in words:
        yield words
        return
    distributed = pytest.importorskip("distributed")
    options = {"n_workers": 1, "processes": False, "dashboard_address": None}
    with distributed.LocalCluster(protocol="tcp://", **options) as cluster:
        address = cluster.scheduler_address
        yield [address if word in ("local", "tcp://head:8786") else word for word in words]


def run_command(words):
    """Run a command of a page; a server is started and stopped."""
    if words[0] in ("simulate", "inspect"):
        with served(*words, folder=Path.cwd()) as url:
            assert url.startswith("http://")
        return
    with with_local_cluster(reduced(words)) as given:
        assert main(given) == 0, words


def follow(page):
    """Run all blocks of a page in order; Python blocks share one namespace."""
    names = {}
    for language, text in blocks(page):
        if language == "python":
            exec(compile(text, page, "exec"), names)
        for words in commands(text) if language == "console" else ():
            run_command(words[1:])


def test_every_page_with_code_is_tested():
    code = {"console", "python"}
    shown = [page for page in pages() if code & {kind for kind, _ in blocks(page)}]
    assert sorted(shown) == sorted([*PREPARED, *ELSEWHERE])


@pytest.mark.usefixtures("without_figures")
@pytest.mark.parametrize("page", PREPARED)
def test_commands_and_code_of_a_page_work(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("recon.batch.schedulers.Processes", Sent)
    prepare = PREPARED[page]
    if prepare:
        prepare(tmp_path)
    follow(page)


def test_first_hour_gives_a_figure_a_mesh_and_a_named_object(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    follow("hour.md")
    (found,) = json.loads(Path("runs/first/objects.json").read_text())["objects"]
    assert found["label"] == "unknown"
    assert 10 < max(found["size"]) < 18  # 14 wide
    assert Path("runs/first/figures/labels.pdf").read_bytes().startswith(b"%PDF")
    assert Path("mesh.glb").read_bytes().startswith(b"glTF")
    assert b"object" in Path("named.ply").read_bytes()[:600]


def parse_command(words):
    """Parse words as the program does, without running the command."""
    command: click.Command = program
    context = click.Context(program, info_name="recon")
    while isinstance(command, click.Group):
        name, command, words = command.resolve_command(context, words)
    command.make_context(name, list(words), parent=context)


def test_every_command_of_the_pages_parses():
    found = [
        words for page in pages() for kind, text in blocks(page) if kind == "console"
        for words in commands(text)
    ]  # fmt: skip
    assert len(found) > 30
    assert {words[0] for words in found} == {"recon"}
    for words in found:
        parse_command(words[1:])
    with pytest.raises(click.NoSuchOption):
        parse_command(["explore", "village", "--no-such-option"])


def test_every_block_with_commands_states_its_language():
    hidden = [text for page in pages() for language, text in blocks(page) if not language]
    assert [text for text in hidden if text.startswith(("recon ", "import "))] == []


def test_files_described_on_the_pages_have_the_described_content(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    stand_ins.walk(tmp_path)
    follow("howto/programs.md")
    assert len(recon.read("scan.ply")) == 2
    assert sorted(recon.read("table.parquet").attributes) == ["time"]


def test_scene_on_the_page_is_valid(tmp_path):
    stand_ins.scene(tmp_path)
    assert len(read_scene(tmp_path / "own.scene").visuals) == 2


def test_links_between_pages_resolve():
    links = [
        (page, link)
        for page in pages().values()
        for link in re.findall(r"\]\(([\w./-]+)\)", page.read_text())
    ]
    assert len(links) > 10
    assert [
        f"{page.name}: {link}" for page, link in links if not (page.parent / link).exists()
    ] == []
