"""Images that a model is trained on."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from recon.runs import train
from recon.settings import Settings


def test_both_16_bit_cameras_share_one_stretch(tmp_path, monkeypatch):
    dark = np.random.default_rng(0).integers(1000, 2000, (20, 30)).astype(np.uint16)
    cv2.imwrite(str(tmp_path / "left.png"), dark)
    cv2.imwrite(str(tmp_path / "right.png"), 2 * dark)
    seen = []

    def detect(image, _settings):
        seen.append(float(image.mean()))
        if len(seen) == 2:
            raise InterruptedError

    monkeypatch.setattr(train, "detect", detect)
    with pytest.raises(InterruptedError):
        train.train_run([tmp_path], Settings(), Path(tmp_path / "model.json"))
    assert seen[1] - seen[0] > 50
