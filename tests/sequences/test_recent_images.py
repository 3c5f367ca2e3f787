"""Images kept while a job reads them several times."""

import numpy as np
import pytest

from recon.sequences import recent
from recon.sequences.recent import RecentImages, recent_image, recent_images


class Decoder:
    """Makes images of one byte a pixel, and counts them."""

    def __init__(self) -> None:
        self.count = 0

    def __call__(self) -> np.ndarray:
        self.count += 1
        return np.full((2, 5), self.count, np.uint8)


def test_an_image_is_decoded_once_in_a_block_and_every_time_outside(tmp_path):
    decode = Decoder()
    with recent_images():
        images = [recent_image(tmp_path / "a.png", decode) for _ in range(3)]
    assert [int(image[0, 0]) for image in images] == [1, 1, 1]
    assert int(recent_image(tmp_path / "a.png", decode)[0, 0]) == 2
    assert int(recent_image(tmp_path / "a.png", decode)[0, 0]) == 3


def test_the_oldest_images_give_way(tmp_path, monkeypatch):
    monkeypatch.setattr(recent, "MOST_BYTES", 25)  # two of them
    images, decode = RecentImages(), Decoder()
    for name in "abca":
        images.read(tmp_path / name, decode)
    assert decode.count == 4
    images.read(tmp_path / "c", decode)
    assert decode.count == 4


def test_an_image_larger_than_all_room_is_decoded_again(tmp_path, monkeypatch):
    monkeypatch.setattr(recent, "MOST_BYTES", 5)
    images, decode = RecentImages(), Decoder()
    for _ in range(2):
        images.read(tmp_path / "a", decode)
    assert decode.count == 2


def test_a_failure_is_not_kept(tmp_path):
    def fail() -> np.ndarray:
        raise ValueError("damaged")

    with recent_images():
        with pytest.raises(ValueError, match="damaged"):
            recent_image(tmp_path / "a", fail)
        assert recent_image(tmp_path / "a", Decoder()).shape == (2, 5)
