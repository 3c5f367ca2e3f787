"""Images of many depths, orientations and formats are read alike, or rejected in one line."""

import io
import struct
import zlib

import cv2
import numpy as np
import PIL.Image
import pytest

from recon.errors import InputError
from recon.notices import collected_notices
from recon.sequences.depth import stretch_of
from recon.sequences.images import read_image, read_pixels
from recon.sequences.pair_images import read_pair


def gradient(low, high, shape=(24, 32)):
    return np.linspace(low, high, shape[0] * shape[1]).reshape(shape)


def test_narrow_ranges_of_16_bit_images_keep_their_levels(tmp_path):
    for low, high in ((0, 4095), (30_000, 30_600)):
        cv2.imwrite(str(tmp_path / "deep.png"), gradient(low, high).astype(np.uint16))
        with collected_notices() as notices:
            image = read_image(tmp_path / "deep.png")
        assert len(np.unique(image)) > 180
        assert np.all(np.diff(image.ravel().astype(int)) >= 0)
        assert [notice.code for notice in notices] == ["depth-stretched"]


def test_both_cameras_share_one_stretch_and_8_bit_images_stay_unchanged(tmp_path):
    dark, bright = (gradient(*ends).astype(np.uint16) for ends in ((1000, 1300), (1200, 1600)))
    cv2.imwrite(str(tmp_path / "l.png"), dark)
    cv2.imwrite(str(tmp_path / "r.png"), bright)
    left, right = read_pair(tmp_path / "l.png", tmp_path / "r.png")
    same_level = np.abs(dark.astype(int)[:, :, None, None] - bright[::6, ::8]) == 0
    where = np.argwhere(same_level)
    assert len(where)
    for row, column, other_row, other_column in where:
        assert left[row, column] == right[::6, ::8][other_row, other_column]
    eight = np.arange(6, dtype=np.uint8).reshape(2, 3)
    np.testing.assert_array_equal(stretch_of([eight])(eight), eight)


def jpeg(image, **options):
    stream = io.BytesIO()
    PIL.Image.fromarray(image).save(stream, "JPEG", **options)
    return stream.getvalue()


@pytest.fixture
def photo():
    rng = np.random.default_rng(3)
    return cv2.GaussianBlur(rng.integers(0, 256, (94, 160, 3), np.uint8), (0, 0), 2)


def test_exif_rotation_is_ignored_with_a_notice(tmp_path, photo):
    exif = PIL.Image.Exif()
    exif[274] = 3
    (tmp_path / "plain.jpg").write_bytes(jpeg(photo))
    (tmp_path / "turned.jpg").write_bytes(jpeg(photo, exif=exif))
    with collected_notices() as notices:
        turned = read_image(tmp_path / "turned.jpg")
        plain = read_image(tmp_path / "plain.jpg")
    np.testing.assert_array_equal(turned, plain)
    assert [notice.code for notice in notices] == ["exif-ignored"]


def test_colour_beside_grey_is_converted_to_grey(tmp_path, photo):
    cv2.imwrite(str(tmp_path / "l.png"), photo)
    cv2.imwrite(str(tmp_path / "r.png"), photo[..., 0])
    with collected_notices() as notices:
        left, right = read_pair(tmp_path / "l.png", tmp_path / "r.png")
    assert left.ndim == right.ndim == 2
    assert [notice.code for notice in notices] == ["colour-missing"]


def test_targa_and_jpeg_with_trailing_bytes_are_read(tmp_path, photo):
    PIL.Image.fromarray(photo).save(tmp_path / "rgb.tga")
    np.testing.assert_array_equal(read_image(tmp_path / "rgb.tga"), photo)
    (tmp_path / "trailer.jpg").write_bytes(jpeg(photo) + b"more than was asked for")
    assert read_image(tmp_path / "trailer.jpg").shape == photo.shape


@pytest.mark.parametrize("options", [{}, {"progressive": True}, {"restart_marker_rows": 1}])
@pytest.mark.parametrize("share", [0.4, 0.8])
def test_truncated_jpeg_with_an_end_marker_is_rejected(tmp_path, photo, options, share):
    data = jpeg(photo, **options)
    (tmp_path / "whole.jpg").write_bytes(data)
    assert read_pixels(tmp_path / "whole.jpg").shape == photo.shape
    (tmp_path / "cut.jpg").write_bytes(data[: int(share * len(data))] + b"\xff\xd9")
    with pytest.raises(InputError, match="is cut short"):
        read_pixels(tmp_path / "cut.jpg")


def test_jpeg_with_a_grey_area_is_not_taken_for_truncated(tmp_path, photo):
    half = photo.copy()
    half[40:] = 128
    (tmp_path / "grey.jpg").write_bytes(jpeg(half))
    assert (read_pixels(tmp_path / "grey.jpg")[-8:] == 128).all()


def test_impossible_image_sizes_are_rejected_without_library_output(tmp_path, capfd):
    header = struct.pack("<2sIHHIIiiHHIIiiII", b"BM", 118, 0, 0, 54, 40, 2**30, 2**30, 1, 24,
                         0, 0, 0, 0, 0, 0)  # fmt: skip
    (tmp_path / "huge.bmp").write_bytes(header + bytes(64))
    chunk = b"IHDR" + struct.pack(">IIBBBBB", 2**24, 2**24, 16, 2, 0, 0, 0)
    end = b"IEND"
    png = b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(part) - 4) + part + struct.pack(">I", zlib.crc32(part))
        for part in (chunk, end)
    )
    (tmp_path / "huge.png").write_bytes(png)
    for name in ("huge.bmp", "huge.png"):
        with pytest.raises(InputError) as caught:
            read_image(tmp_path / name)
        assert "\n" not in str(caught.value)
    assert capfd.readouterr().err == ""


@pytest.mark.parametrize(
    ("levels", "fault"),
    [
        (np.full((4, 6), 0.5, np.float32), "contains floating-point numbers, but 8 or 16 bits"),
        (np.full((4, 6), 70_000, np.int32), "levels 70000 to 70000, but 0 to 65535 are needed"),
        (np.full((4, 6), -1, np.int32), "levels -1 to -1, but 0 to 65535 are needed"),
    ],
)
def test_levels_that_are_not_16_bits_are_rejected(tmp_path, levels, fault):
    PIL.Image.fromarray(levels).save(tmp_path / "deep.tif")
    with pytest.raises(InputError, match=fault):
        read_pixels(tmp_path / "deep.tif")


def test_16_bit_levels_stored_in_32_bits_are_read(tmp_path):
    levels = gradient(0, 65_535).astype(np.int32)
    PIL.Image.fromarray(levels).save(tmp_path / "deep.tif")
    np.testing.assert_array_equal(read_pixels(tmp_path / "deep.tif"), levels)
