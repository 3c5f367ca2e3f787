"""The pages that a stranger follows, line by line, in a folder of their own."""

import json
import re
import shlex
from pathlib import Path

import pytest

from recon.cli import main

DOCS = Path(__file__).parents[1] / "docs"


def blocks(page):
    """Language and text of each block of a page."""
    return re.findall(r"^```(console|python)\n(.*?)^```", (DOCS / page).read_text(), re.M | re.S)


def follow(page):
    """Do what a page says, in order."""
    for language, text in blocks(page):
        if language == "python":
            exec(compile(text, page, "exec"), {})
            continue
        for line in text.splitlines():
            words = shlex.split(line.partition(" #")[0])
            assert main(words[1:]) == 0, line


def test_the_first_hour_ends_with_a_figure_a_mesh_and_a_named_object(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    follow("hour.md")
    (found,) = json.loads(Path("runs/first/objects.json").read_text())["objects"]
    assert found["label"] == "unknown"
    assert 10 < max(found["size"]) < 18  # 14 wide
    assert Path("runs/first/figures/labels.pdf").read_bytes().startswith(b"%PDF")
    assert Path("mesh.glb").read_bytes().startswith(b"glTF")
    assert b"object" in Path("named.ply").read_bytes()[:600]


@pytest.mark.parametrize("page", ["start.md", "concepts/occupancy.md"])
def test_what_a_page_says_works(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert blocks(page)
    follow(page)


def test_links_between_pages_lead_somewhere():
    pages = [*DOCS.glob("*.md"), *DOCS.glob("[chr]*/*.md")]
    links = [
        (page, link) for page in pages for link in re.findall(r"\]\(([\w./-]+)\)", page.read_text())
    ]
    assert len(links) > 10
    assert [
        f"{page.name}: {link}" for page, link in links if not (page.parent / link).exists()
    ] == []
