"""Put Middlebury's Motorcycle pair (2014, quarter size) into data/motorcycle/.

The images and the true disparity come from scikit-image's own package and are not committed.
"""

from pathlib import Path

import cv2
import numpy as np

FOLDER = Path(__file__).parents[1] / "data" / "motorcycle"
FILES = ("left.png", "right.png", "disp_left.pfm")


def main() -> None:
    """Write what is missing."""
    if all((FOLDER / name).is_file() for name in FILES):
        return
    from skimage.data import stereo_motorcycle

    left, right, disparity = stereo_motorcycle()
    images = (left[..., ::-1], right[..., ::-1], disparity.astype(np.float32))
    for name, image in zip(FILES, images, strict=True):
        partial = FOLDER / f"partial-{name}"
        if not cv2.imwrite(str(partial), image):
            raise OSError(f"{partial} could not be written")
        partial.replace(FOLDER / name)


if __name__ == "__main__":
    main()
