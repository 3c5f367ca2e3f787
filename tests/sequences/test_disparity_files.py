"""Disparities in PFM and image files, by the names and scales of other tools."""

import cv2
import numpy as np
import pytest

from recon.errors import InputError
from recon.sequences.pfm import decode_pfm
from recon.sequences.truth import read_truth, read_truth_file


@pytest.mark.parametrize(
    "header",
    ["Pf\n4 3\n-0.003922\n", "Pf\r\n4 3\r\n-1.0\r\n", "Pf 4 3 -1\n", "Pf\n# words\n4 3\n-255.0\n"],
)
def test_every_variant_of_pfm_is_read(tmp_path, header):
    stored = np.arange(12, dtype="<f4").reshape(3, 4) + 1.25
    (tmp_path / "disp_left.pfm").write_bytes(header.encode() + stored[::-1].tobytes())
    np.testing.assert_array_equal(read_truth(tmp_path).disparity_px, stored)


def test_big_endian_pfm_is_read_and_a_truncated_one_rejected():
    stored = np.arange(6, dtype=">f4").reshape(2, 3)
    data = b"Pf\n3 2\n1.0\n" + stored[::-1].tobytes()
    np.testing.assert_array_equal(decode_pfm(data, "map"), stored)
    for broken in (data[:-1], b"Pf\n99999999 99999999\n1\n", b"Pf\n3 -2\n1\n", b"Pf"):
        with pytest.raises(InputError, match=r"claims|header"):
            decode_pfm(broken, "map")


def test_truth_in_colour_needs_equal_channels(tmp_path):
    grey = np.full((4, 5), 24, np.uint8)
    for name, last, fits in (("same", 24, True), ("other", 25, False)):
        cv2.imwrite(
            str(tmp_path / f"{name}.png"), np.dstack([grey, grey, np.full_like(grey, last)])
        )
        if fits:
            assert read_truth_file(tmp_path / f"{name}.png", 8).disparity_px[0, 0] == 3
            continue
        with pytest.raises(InputError, match="3 channels that differ"):
            read_truth_file(tmp_path / f"{name}.png", 8)


def test_truth_of_kitti_and_middlebury_is_found_and_scaled(tmp_path):
    stored = np.array([[0, 256, 640]], np.uint16)
    (tmp_path / "kitti").mkdir()
    cv2.imwrite(str(tmp_path / "kitti" / "disp_occ_0.png"), stored)
    found = read_truth(tmp_path / "kitti").disparity_px
    np.testing.assert_array_equal(found, [[np.nan, 1.0, 2.5]])
    for name in ("disp1", "disp2"):
        (tmp_path / name).mkdir()
        cv2.imwrite(str(tmp_path / name / f"{name}.png"), np.full((2, 2), 9, np.uint8))
        assert (read_truth(tmp_path / name, 3).disparity_px == 3).all()
