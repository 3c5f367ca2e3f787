"""Names of columns: those of any program are written in every format, and read back."""

import numpy as np
import pytest

from recon.errors import InputError
from recon.exports import read, write
from recon.notices import collected_notices
from recon.records import PointCloud
from tests.exports.test_tables import KEEPING

TABLES = [*KEEPING, ".xyz"]
WORDS = [".ply", ".pcd", ".xyz", ".csv"]


def named(*names):
    values = np.arange(5.0) + 0.5
    return PointCloud(points=np.arange(15.0).reshape(5, 3), attributes=dict.fromkeys(names, values))


def written_and_read(cloud, path):
    with collected_notices() as notices:
        write(cloud, path)
        again = read(path)
    return again, [one.text for one in notices if one.code == "columns-dropped"]


@pytest.mark.parametrize("ending", TABLES)
@pytest.mark.parametrize(
    "name", ["höhe", "名前", "Red", "red", "__x", "end_header", "1st", "<a&b>"]
)
def test_any_word_names_a_column(tmp_path, ending, name):
    again, dropped = written_and_read(named(name), tmp_path / f"cloud{ending}")
    assert dropped == []
    (values,) = again.attributes.values()
    assert np.array_equal(values, named(name).attributes[name])
    if not name.startswith("__"):
        assert list(again.attributes) == [name]


@pytest.mark.parametrize("ending", WORDS)
@pytest.mark.parametrize("name", ["a b", "a\tb", "a,b", "a#b", 'a"b', "a\u00a0b", "a\nb"])
def test_name_of_several_words_becomes_one_in_headers_of_text(tmp_path, ending, name):
    again, dropped = written_and_read(named(name), tmp_path / f"cloud{ending}")
    assert list(again.attributes) == ["a_b"]
    assert dropped == []


@pytest.mark.parametrize("ending", WORDS)
def test_column_whose_name_is_taken_is_dropped_with_a_notice(tmp_path, ending):
    cloud = named("a b", "a_b", "a,b")
    again, dropped = written_and_read(cloud, tmp_path / f"cloud{ending}")
    assert list(again.attributes) == ["a_b"]
    assert len(dropped) == 1
    assert "a b, a,b" in dropped[0]


@pytest.mark.parametrize("name", ["..", "a/b", "__private"])
def test_name_of_a_path_does_not_leave_the_zarr_group(tmp_path, name):
    again, dropped = written_and_read(named(name), tmp_path / "cloud.zarr")
    assert len(again.attributes) == 1
    assert dropped == []
    assert [one.name for one in tmp_path.iterdir()] == ["cloud.zarr"]


def test_name_too_long_for_a_file_is_dropped_with_a_notice(tmp_path):
    again, dropped = written_and_read(named("n" * 300, "kept"), tmp_path / "cloud.zarr")
    assert list(again.attributes) == ["kept"]
    assert len(dropped) == 1


@pytest.mark.parametrize("header", ["x,x,y,z", "X,x,y,z", "x,y,z,a,a"])
def test_column_named_twice_is_refused(tmp_path, header):
    num = len(header.split(","))
    row = ",".join(map(str, range(num)))
    (tmp_path / "cloud.csv").write_text(f"{header}\n{row}\n")
    with pytest.raises(InputError, match=r"two columns are named [xa]: name all columns"):
        read(tmp_path / "cloud.csv")


@pytest.mark.parametrize("name", ["colours", "normals"])
def test_array_of_other_points_is_refused(tmp_path, name):
    np.savez(tmp_path / "cloud.npz", points=np.zeros((5, 3)), **{name: np.zeros((4, 3), np.uint8)})
    with pytest.raises(InputError, match=rf"{name} has shape \(4, 3\), but one row for each of 5"):
        read(tmp_path / "cloud.npz")
