"""An image is read completely or rejected."""

import cv2
import numpy as np
import pytest

from recon.errors import InputError
from recon.sequences.images import read_image


@pytest.fixture
def colours():
    return np.random.default_rng(1).integers(0, 256, (20, 30, 3), np.uint8)


def test_colours_are_read_as_rgb_and_grey_stays_grey(tmp_path, colours):
    cv2.imwrite(str(tmp_path / "rgb.png"), colours[..., ::-1])
    cv2.imwrite(str(tmp_path / "grey.png"), colours[..., 0])
    np.testing.assert_array_equal(read_image(tmp_path / "rgb.png"), colours)
    np.testing.assert_array_equal(read_image(tmp_path / "grey.png"), colours[..., 0])


def test_16_bit_images_become_8_bit_and_alpha_is_a_mask(tmp_path, colours):
    cv2.imwrite(str(tmp_path / "deep.png"), colours[..., 0].astype(np.uint16) * 257)
    np.testing.assert_array_equal(read_image(tmp_path / "deep.png"), colours[..., 0])
    alpha = np.full((20, 30, 1), 128, np.uint8)
    alpha[:, :10] = 127
    cv2.imwrite(str(tmp_path / "alpha.png"), np.concatenate([colours[..., ::-1], alpha], axis=2))
    image = read_image(tmp_path / "alpha.png")
    np.testing.assert_array_equal(image[:, 10:], colours[:, 10:])
    assert not image[:, :10].any()


@pytest.mark.parametrize("ending", ["png", "jpg"])
@pytest.mark.parametrize("share", [0.1, 0.5, 0.9, 0.999])
def test_truncated_image_is_rejected(tmp_path, colours, ending, share, capfd):
    path = tmp_path / f"cut.{ending}"
    cv2.imwrite(str(path), colours)
    data = path.read_bytes()
    assert read_image(path).shape == colours.shape
    path.write_bytes(data[: int(share * len(data))])
    with pytest.raises(InputError, match=rf"cut\.{ending} is cut short, but a whole image"):
        read_image(path)
    assert capfd.readouterr().err == ""


def test_damaged_image_is_rejected(tmp_path, colours, capfd):
    path = tmp_path / "hit.png"
    cv2.imwrite(str(path), colours)
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 0xFF
    path.write_bytes(bytes(data))
    with pytest.raises(InputError, match=r"is damaged \(a checksum is wrong\)"):
        read_image(path)
    assert capfd.readouterr().err == ""


def test_missing_empty_or_invalid_image_is_rejected(tmp_path):
    with pytest.raises(InputError, match=r"cannot be read \(No such file"):
        read_image(tmp_path / "none.png")
    (tmp_path / "empty.png").touch()
    with pytest.raises(InputError, match="is empty"):
        read_image(tmp_path / "empty.png")
    (tmp_path / "words.png").write_text("words")
    with pytest.raises(InputError, match="is not an image"):
        read_image(tmp_path / "words.png")
