"""Claims of a file are checked against its content: one line, immediately, in little memory."""

import io
import os
import re
import struct
import zipfile

import numpy as np
import pytest

from recon.errors import InputError
from recon.exports import FORMATS, read, write
from recon.exports.formats import Format
from recon.files import memory_limit
from recon.voxelmap import VoxelMap
from tests.exports.maps import sample_cloud, sample_map
from tests.exports.rejected import assert_rejected


@pytest.fixture
def las(tmp_path):
    write(sample_cloud(num=50), tmp_path / "a.las")
    return tmp_path / "a.las"


@pytest.mark.parametrize(
    ("offset", "form", "value", "message"),
    [
        (100, "<I", 2**31, "variable records are claimed"),
        (100, "<I", 3, "variable records"),
        (247, "<Q", 2**40, "1099511627776 points are claimed"),
        (247, "<Q", 51, "51 points are claimed"),
        (96, "<I", 2**31, "its points begin at byte 2147483648"),
        (105, "<H", 1, "points of format 7 have 1 bytes"),
        (104, "<B", 63, "not a whole LAS file"),
        (131, "<d", 0.0, "its scales are"),
        (131, "<d", float("nan"), "its scales are"),
        (155, "<d", float("inf"), "its scales are"),
        (243, "<I", 2**20, "extended records are claimed"),
    ],
)
def test_false_las_header_is_rejected(las, offset, form, value, message):
    content = bytearray(las.read_bytes())
    struct.pack_into(form, content, offset, value)
    las.write_bytes(content)
    assert_rejected(las, message)


def test_las_dimension_without_a_name_is_rejected(las):
    content = las.read_bytes()
    assert content.count(b"sigma\0") == 1
    las.write_bytes(content.replace(b"sigma\0", bytes(6)))
    assert_rejected(las, "one of its extra dimensions has no name")


@pytest.mark.parametrize(
    ("origin", "size"), [("[1e300, 0, 0]", 1), ("[0, 0]", 1e-300), ("[0, 0]", 1e300), ("[]", 1)]
)
def test_nav2_map_out_of_range_is_rejected(tmp_path, origin, size):
    (tmp_path / "a.pgm").write_bytes(b"P5 2 1 255\n\x00\xfe")
    path = tmp_path / "a.yaml"
    path.write_text("image: a.pgm\nresolution: 1.0\norigin: [-2147483648.0, 0.0, 1.0]\n")
    assert len(read(path)) == 1
    path.write_text(f"image: a.pgm\nresolution: {size!r}\norigin: {origin}\n")
    assert_rejected(path, "resolution is .*, origin")


@pytest.mark.parametrize(
    ("at", "found"),
    [
        ("layer", "chunk 0 reaches beyond"),
        ("item", "items are not points of"),
        ("size", "chunks of .* points are claimed"),
    ],
)
def test_inconsistent_laz_is_rejected(tmp_path, at, found):
    pytest.importorskip("lazrs")
    path = tmp_path / "a.laz"
    write(sample_cloud(num=500), path)
    content = bytearray(path.read_bytes())
    (start,) = struct.unpack_from("<I", content, 96)
    (point_bytes,) = struct.unpack_from("<H", content, 105)
    record = content.index(b"laszip encoded")
    # The chunk's first layer, after its first point and count; the bytes of the first item; the
    # upper half of the chunk size.
    packing = record + 52
    place = {"layer": start + 8 + point_bytes + 4, "item": packing + 36, "size": packing + 14}[at]
    content[place : place + 2] = b"\xff\xff"
    path.write_bytes(content)
    assert_rejected(path, found)


@pytest.mark.parametrize("cut", [0.5, 0.9, 0.99])
def test_truncated_laz_is_rejected(tmp_path, cut, capfd):
    pytest.importorskip("lazrs")
    write(sample_cloud(num=500), tmp_path / "a.laz")
    content = (tmp_path / "a.laz").read_bytes()
    (tmp_path / "a.laz").write_bytes(content[: int(cut * len(content))])
    assert_rejected(tmp_path / "a.laz", "not a whole LAZ file")
    assert capfd.readouterr() == ("", "")


def write_zip_bomb(path, name, shape, packing):
    """Write an npz of zeros that is small as a file."""
    with zipfile.ZipFile(path, "w", packing) as archive, archive.open(f"{name}.npy", "w") as file:
        np.lib.format.write_array_header_1_0(
            file, {"descr": "<f8", "fortran_order": False, "shape": shape}
        )
        zeros = bytes(1 << 20)
        for _ in range(8 * int(np.prod(shape)) >> 20):
            file.write(zeros)


@pytest.mark.parametrize("packing", [zipfile.ZIP_DEFLATED, zipfile.ZIP_BZIP2])
def test_zip_bomb_is_rejected(tmp_path, packing):
    write_zip_bomb(tmp_path / "a.npz", "points", (1 << 20, 4), packing)
    with memory_limit(64 << 20):
        assert_rejected(tmp_path / "a.npz", "GB are allowed; give --max-memory")


def test_false_array_header_allocates_no_memory(tmp_path):
    header = io.BytesIO()
    np.lib.format.write_array_header_1_0(
        header, {"descr": "<f8", "fortran_order": False, "shape": (1 << 40, 3)}
    )
    with zipfile.ZipFile(tmp_path / "a.npz", "w") as archive:
        archive.writestr("points.npy", header.getvalue() + b"\0" * 24)
    assert_rejected(tmp_path / "a.npz", "claims 26388279066624 bytes, but holds 24")


def test_highly_compressed_parquet_is_rejected(tmp_path):
    arrow = pytest.importorskip("pyarrow")
    from pyarrow import parquet

    columns = {name: np.zeros(1 << 21) for name in "xyz"}
    parquet.write_table(arrow.table(columns), tmp_path / "a.parquet")
    assert (tmp_path / "a.parquet").stat().st_size < 1 << 20
    with memory_limit(16 << 20):
        assert_rejected(tmp_path / "a.parquet", "GB are allowed; give --max-memory")


def write_octomap(path, size, res, nodes):
    head = f"# Octomap OcTree binary file\nid OcTree\nsize {size}\nres {res}\ndata\n"
    path.write_bytes(head.encode() + nodes)


@pytest.mark.parametrize("levels", [0, 1, 2])
def test_octomap_leaf_of_too_many_cells_is_rejected(tmp_path, levels):
    """A few bytes of `.bt`: each node has one inner child, the last one eight occupied leaves."""
    pytest.importorskip("pyoctomap")
    nodes = struct.pack("<H", 3) * levels + struct.pack("<H", 0xAAAA)
    write_octomap(tmp_path / "a.bt", 9 + levels, 0.1, nodes)
    assert_rejected(tmp_path / "a.bt", "GB are allowed; give --max-memory")


@pytest.mark.parametrize("res", ["1e-300", "0", "-1", "nan", "1e300"])
def test_invalid_octomap_resolution_is_rejected(tmp_path, res):
    write_octomap(tmp_path / "a.bt", 1, res, struct.pack("<H", 0))
    assert_rejected(tmp_path / "a.bt", "its cells have size")


@pytest.mark.parametrize("missing", ["x", "count"])
def test_zarr_with_a_missing_chunk_is_rejected(tmp_path, missing):
    pytest.importorskip("zarr")
    write(sample_map(()), tmp_path / "a.zarr")
    for chunk in (tmp_path / "a.zarr" / missing / "c").iterdir():
        chunk.unlink()
    assert_rejected(tmp_path / "a.zarr", f"{missing} has 0 of 1 chunks")


@pytest.mark.parametrize("length", [10**12, -1])
def test_zarr_with_a_false_shape_is_rejected(tmp_path, length):
    pytest.importorskip("zarr")
    write(sample_cloud(), tmp_path / "a.zarr")
    for about in (tmp_path / "a.zarr").rglob("zarr.json"):
        claim = re.sub(r'("shape": \[\s*)300', rf"\g<1>{length}", about.read_text())
        about.write_text(claim)
    assert_rejected(tmp_path / "a.zarr", "GB are allowed|not a whole Zarr group")


@pytest.mark.parametrize(
    ("name", "values"),
    [("count", -5), ("cell_size", -1.0), ("cell_size", np.nan), ("cell_size", 0.0)],
)
def test_table_with_invalid_cells_is_rejected(tmp_path, name, values):
    pytest.importorskip("pyarrow")
    from recon.exports.columns import columns_of
    from recon.exports.parquet import write as write_columns

    columns = columns_of(sample_map(()).occupied(1))
    columns[name] = np.full(len(columns[name]), values)
    write_columns(tmp_path / "a.parquet", columns)
    assert_rejected(tmp_path / "a.parquet", "count|cell_size")


def test_table_with_mixed_cell_sizes_is_rejected(tmp_path):
    pytest.importorskip("pyarrow")
    from recon.exports.columns import columns_of
    from recon.exports.parquet import write as write_columns

    columns = columns_of(sample_map(()).occupied(1))
    columns["cell_size"] = np.arange(1.0, 1.0 + len(columns["x"]))
    write_columns(tmp_path / "a.parquet", columns)
    assert_rejected(tmp_path / "a.parquet", "differ in cell_size")


@pytest.mark.parametrize("ending", sorted({*FORMATS.names()} - {".zarr"}))
def test_pipes_devices_and_folders_are_rejected(tmp_path, ending):
    os.mkfifo(tmp_path / f"pipe{ending}")
    assert_rejected(tmp_path / f"pipe{ending}", "is a pipe or device, but a file is needed")
    (tmp_path / f"zero{ending}").symlink_to("/dev/zero")
    assert_rejected(tmp_path / f"zero{ending}", "is a pipe or device, but a file is needed")
    (tmp_path / f"folder{ending}").mkdir()
    assert_rejected(tmp_path / f"folder{ending}", "is a folder, but a file is needed")


def test_sparse_file_of_a_terabyte_is_rejected(tmp_path):
    head = b"ply\nformat binary_little_endian 1.0\nelement vertex 80000000000\n"
    head += b"property float x\nproperty float y\nproperty float z\nend_header\n"
    with (tmp_path / "a.ply").open("wb") as file:
        file.write(head)
        file.truncate(1 << 40)
    assert_rejected(tmp_path / "a.ply", "GB are allowed; give --max-memory")


def test_file_name_that_is_not_utf8_is_rejected(tmp_path):
    path = os.fsdecode(os.fsencode(tmp_path) + b"/\xff.ply")
    with pytest.raises(InputError, match=r"\\xff\.ply: its name is not UTF-8"):
        read(path)
    with pytest.raises(InputError, match="its name is not UTF-8"):
        write(sample_cloud(), path)


def test_all_formats_are_registered():
    assert all(isinstance(form, Format) for _, form in FORMATS.parts())
    assert len(list(FORMATS.parts())) == len(FORMATS.names())


def test_truncated_map_is_rejected(tmp_path):
    VoxelMap(0.5).save(tmp_path / "a.npz")
    content = (tmp_path / "a.npz").read_bytes()
    (tmp_path / "a.npz").write_bytes(content[:-10])
    assert_rejected(tmp_path / "a.npz", "not a whole npz archive")


def test_false_npy_header_allocates_no_memory(tmp_path):
    with (tmp_path / "a.npy").open("wb") as file:
        header = {"descr": "<f8", "fortran_order": False, "shape": (10**12, 3)}
        np.lib.format.write_array_header_1_0(file, header)
    assert_rejected(tmp_path / "a.npy", "claims 24000000000000 bytes, but holds")


def test_archive_of_too_many_arrays_is_rejected(tmp_path):
    stream = io.BytesIO()
    np.save(stream, np.zeros(3))
    with zipfile.ZipFile(tmp_path / "a.npz", "w") as archive:
        for number in range(2001):
            archive.writestr(f"{number}.npy", stream.getvalue())
    assert_rejected(tmp_path / "a.npz", "2001 arrays, but at most 2000 are allowed")


def test_overlong_line_is_rejected(tmp_path):
    (tmp_path / "a.xyz").write_text("1 " * 30_000)
    assert_rejected(tmp_path / "a.xyz", "a line has more than 50000 bytes")


def test_zarr_with_a_device_is_rejected(tmp_path):
    (tmp_path / "a.zarr").mkdir()
    (tmp_path / "a.zarr" / "zarr.json").symlink_to("/dev/zero")
    assert_rejected(tmp_path / "a.zarr", "is a pipe or device")
