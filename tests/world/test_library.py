"""Shipped scenes are found by name from any folder; files take precedence."""

import pytest

from recon.errors import InputError
from recon.world.library import find_scene, scene_names


def test_shipped_scene_is_found_by_name_from_any_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert "village" in scene_names()
    assert find_scene("village").read_text().startswith("#")


def test_file_takes_precedence_over_a_shipped_scene(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "village").write_text("mine")
    assert find_scene("village").read_text() == "mine"


def test_folder_of_the_same_name_is_not_a_scene(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "village").mkdir()
    assert find_scene("village").read_text().startswith("#")


@pytest.mark.parametrize("name", ["vilage", "no/village", "../village"])
def test_unknown_scene_is_rejected_with_the_nearest_name(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match=r"neither a file nor a scene that ships \(.*village"):
        find_scene(name)
