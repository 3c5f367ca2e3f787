"""Text tables with a header, with given column names, or with neither."""

import numpy as np
import pytest

from recon.errors import InputError
from recon.exports import read, write
from recon.notices import collected_notices
from tests.exports.maps import same, sample_cloud


def text(tmp_path, content, name="cloud.txt"):
    (tmp_path / name).write_bytes(content.encode())
    return tmp_path / name


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("a.xyz", "1 2 3\n4 5 6\n"),
        ("a.txt", "# made by hand\n1\t2\t3\r\n\r\n4\t5\t6"),
        ("a.csv", "x,y,z\n1,2,3\n4,5,6\n"),
        ("a.csv", '"X","Y","Z"\n1.0, 2.0, 3.0\n4,5,6\n'),
        ("a.csv", "x;y;z\n1,0;2,0;3,0\n4;5;6\n"),
        ("a.csv", "\ufeffx,y,z\n1,2,3\n4,5,6\n"),
        ("a.asc", "//X Y Z\n1 2 3\n4 5 6\n"),
        ("a.pts", "2\n1 2 3\n4 5 6\n"),
        ("a.csv", "z,name,x,y\n3,a,1,2\n6,b,4,5\n"),
    ],
)
def test_coordinates_are_read_in_any_notation(tmp_path, name, content):
    cloud = read(text(tmp_path, content, name))
    assert cloud.points.tolist() == [[1, 2, 3], [4, 5, 6]]
    assert cloud.colours is None
    assert cloud.attributes == {}


@pytest.mark.parametrize(
    ("content", "colours", "attributes"),
    [
        ("1 2 3 255 128 0\n4 5 6 0 0 1\n", [[255, 128, 0], [0, 0, 1]], {}),
        ("1 2 3 9 128 0 255\n4 5 6 0 0 1 255\n", [[9, 128, 0], [0, 0, 1]], {"alpha"}),
        ("1 2 3 1.0 0.5 0.0\n4 5 6 0 0 1\n", [[255, 128, 0], [0, 0, 255]], {}),
        ("1 2 3 0 0 1\n4 5 6 0 1 0\n", [[0, 0, 1], [0, 1, 0]], {}),
        ("1 2 3 0.0 0.6 0.8\n4 5 6 0.0 0.0 -1.0\n", None, {"nx", "ny", "nz"}),
        ("1 2 3 40\n4 5 6 50\n", None, {"intensity"}),
        ("1 2 3 -9 255 0 0\n4 5 6 7 0 1 2\n", [[255, 0, 0], [0, 1, 2]], {"intensity"}),
        (
            "1 2 3 9 8 7 0.0 0.6 0.8\n4 5 6 6 5 4 0.6 0.8 0.0\n",
            [[9, 8, 7], [6, 5, 4]],
            {"nx", "ny", "nz"},
        ),
        ("1 2 3 -5 6\n4 5 6 7 8\n", None, {"column_3", "column_4"}),
    ],
)
def test_unnamed_columns_are_identified_by_their_range(tmp_path, content, colours, attributes):
    cloud = read(text(tmp_path, content))
    assert (None if cloud.colours is None else cloud.colours.tolist()) == colours
    assert set(cloud.attributes) == set(attributes)


def test_given_names_override_the_header(tmp_path):
    path = text(tmp_path, "7 1 2 3 255 0 9\n7 4 5 6 0 1 9\n")
    cloud = read(path, columns=["_", "x", "z", "y", "label", "time", "_"])
    assert cloud.points.tolist() == [[1, 3, 2], [4, 6, 5]]
    assert cloud.attributes["label"].tolist() == [255, 0]
    assert set(cloud.attributes) == {"label", "time"}


@pytest.mark.parametrize("ending", [".csv", ".xyz", ".txt", ".asc"])
def test_written_table_round_trips(tmp_path, ending):
    write(sample_cloud(), tmp_path / f"cloud{ending}")
    same(read(tmp_path / f"cloud{ending}"), sample_cloud())


def test_pts_keeps_intensity_and_colours(tmp_path):
    write(sample_cloud(with_sigma=False), tmp_path / "cloud.pts")
    again = read(tmp_path / "cloud.pts")
    assert np.array_equal(again.points, sample_cloud().points)
    assert np.array_equal(again.colours, sample_cloud().colours)


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("a.txt", "", "it holds no points"),
        ("a.txt", "1 2 3\n4 5\n", "has 2 values, but the first row has 3"),
        ("a.txt", "1 2 3\n4 5 x\n", "'x' is not a number"),
        ("a.txt", "1 2 3\n4 5 1_0\n", "is not a number"),
        ("a.txt", "1 2\n4 5\n", "a row has 2 values, but x, y and z are needed"),
        ("a.pts", "3\n1 2 3\n4 5 6\n", "3 points are claimed, but 2 follow"),
        ("a.csv", "x,y\n1,2\n", "'x' is not a number"),
        ("a.csv", "x,y,z\n1,2,3\n4,5,6,7\n", "has 4 values"),
        ("a.csv", "x,y,z,red,green,blue\n1,2,3,-1,2,70000\n", "colours go from -1 to 70000"),
    ],
)
def test_invalid_table_is_rejected_in_one_line(tmp_path, name, content, message):
    path = text(tmp_path, content, name)
    with pytest.raises(InputError, match=message) as error:
        read(path)
    assert str(error.value).startswith(str(path))
    assert "\n" not in str(error.value)


def test_wrong_number_of_column_names_is_rejected(tmp_path):
    with pytest.raises(InputError, match="a row has 3 values, but 2 are"):
        read(text(tmp_path, "1 2 3\n"), columns=["x", "y"])


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ('"X","Y","Z","Class"\n"1.0","2.0","3.0","a tree, old"\n"4.0","5.0","6.0","car"\n', {}),
        (",x,y,z\n0,1,2,3\n1,4,5,6\n", {"column_0": [0, 1]}),
        ("easting,northing,elevation\n1,2,3\n4,5,6\n", {}),
        ('"Points:0","Points:1","Points:2","t"\n1,2,3,7\n4,5,6,8\n', {"t": [7, 8]}),
        ("X [m];Y [m];Z [m];t [s]\n1,0;2,0;3,0;7,0\n4,0;5,0;6,0;8,0\n", {"t [s]": [7, 8]}),
    ],
)
def test_tables_of_other_programs_are_read(tmp_path, text, named):
    (tmp_path / "a.csv").write_text(text)
    with collected_notices():
        cloud = read(tmp_path / "a.csv")
    np.testing.assert_array_equal(cloud.points, [[1, 2, 3], [4, 5, 6]])
    assert {name: list(values) for name, values in cloud.attributes.items()} == named
    (tmp_path / "a.csv").write_text(text, encoding="utf-16")
    with collected_notices():
        np.testing.assert_array_equal(read(tmp_path / "a.csv").points, cloud.points)


def test_header_without_all_three_coordinates_is_rejected(tmp_path):
    (tmp_path / "a.csv").write_text("easting,northing,speed\n1,2,3\n")
    with pytest.raises(InputError, match="'easting' is not a number"):
        read(tmp_path / "a.csv")


@pytest.mark.parametrize(
    "text",
    [
        "%time,field.x,field.y,field.z\n1500000000,1,2,3\n1500000001,4,5,6\n",
        "sep=;\nx;y;z\n1;2;3\n4;5;6\n",
        "; scanner 7\n; 2 points\n1 2 3\n4 5 6\n",
        "x y z label\n1 2 3 tree\n4 5 6 car\n",
    ],
)
def test_other_headers_and_comments_are_read(tmp_path, text):
    (tmp_path / "a.txt").write_text(text)
    with collected_notices() as notices:
        np.testing.assert_array_equal(read(tmp_path / "a.txt").points, [[1, 2, 3], [4, 5, 6]])
    assert [notice.code for notice in notices] == ["columns-dropped"] * ("tree" in text)


GRID = "ncols 3\nnrows 2\nxllcorner 500000\nyll{0} 10\ncellsize 2\nNODATA_value -9\n1 2 3\n4 -9 6\n"


@pytest.mark.parametrize(("mark", "south"), [("corner", 11.0), ("center", 10.0)])
def test_elevation_grid_gives_points_at_cell_centres(tmp_path, mark, south):
    (tmp_path / "a.asc").write_text(GRID.format(mark))
    np.testing.assert_array_equal(
        read(tmp_path / "a.asc").points,
        [[500001 + 2 * x, south + 2 * y, z] for x, y, z in
         [(0, 1, 1), (1, 1, 2), (2, 1, 3), (0, 0, 4), (2, 0, 6)]],
    )  # fmt: skip


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("ncols 3", "ncols 4", "4 x 2 values are claimed, but 6 follow"),
        ("ncols 3", "ncols 1e12", "memory"),
        ("ncols 3", "ncols -3", "ncols is -3, but a positive whole number"),
        ("ncols 3", "ncols 1.5", "ncols is 1.5, but a positive whole number"),
        ("xllcorner 500000", "xllcorner nan", "it has no finite xllcorner"),
        ("ncols 3", "ncols three", "'three' is not a number"),
        ("ncols 3", "ncols", "is not a name and a number"),
        ("xllcorner 500000\n", "", "it has no finite xllcorner"),
        ("cellsize 2", "cellsize nan", "cellsize is nan"),
        ("1 2 3\n4 -9 6\n", "", "but 0 follow"),
    ],
)
def test_elevation_grid_that_contradicts_its_header_is_rejected(tmp_path, old, new, message):
    (tmp_path / "a.asc").write_text(GRID.format("corner").replace(old, new))
    with pytest.raises(InputError, match=message) as error:
        read(tmp_path / "a.asc")
    assert "\n" not in str(error.value)
