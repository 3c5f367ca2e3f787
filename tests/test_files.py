"""Files appear complete or not at all."""

import pytest

from recon.files import atomic_path


def test_file_appears_only_when_complete(tmp_path):
    path = tmp_path / "map.nii.npz"
    path.write_text("old")
    with atomic_path(path) as temporary:
        assert temporary.parent == tmp_path
        assert temporary.suffixes == path.suffixes
        temporary.write_text("new")
        assert path.read_text() == "old"
    assert path.read_text() == "new"
    assert list(tmp_path.iterdir()) == [path]


def test_missing_folder_is_named(tmp_path):
    with pytest.raises(FileNotFoundError) as error, atomic_path(tmp_path / "no" / "map.npz"):
        pass
    assert error.value.filename == str(tmp_path / "no")


def cut_short(path):
    with atomic_path(path) as temporary:
        temporary.write_text("half")
        raise RuntimeError("cut")


def test_failure_keeps_the_existing_file(tmp_path):
    path = tmp_path / "map.npz"
    path.write_text("old")
    with pytest.raises(RuntimeError, match="cut"):
        cut_short(path)
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_file_below_a_file_is_refused_for_what_it_is(tmp_path):
    (tmp_path / "notes").touch()
    with pytest.raises(NotADirectoryError), atomic_path(tmp_path / "notes" / "map.npz"):
        pass
