"""A matcher of images: OpenCV's block matching, one disparity per pixel."""

import cv2
import numpy as np

import recon


def match(left: recon.Image, right: recon.Image, settings: recon.MatchingSettings) -> recon.Matches:
    """The pixels of the left image that block matching finds in the right one."""
    steps = 16 * ((settings.max_disparity - settings.min_disparity) // 16 + 1)
    blocks = cv2.StereoBM.create(numDisparities=steps, blockSize=11)
    blocks.setMinDisparity(settings.min_disparity)
    greys = (cv2.cvtColor(i, cv2.COLOR_RGB2GRAY) if i.ndim == 3 else i for i in (left, right))
    disparity_px = np.asarray(blocks.compute(*greys), np.float64) / 16.0
    v, u = np.nonzero(disparity_px >= settings.min_disparity)
    return recon.Matches(
        points_px=np.column_stack([u, v]).astype(np.float64),
        disparity_px=disparity_px[v, u],
        sigma_px=np.full(len(u), 0.3),
        score=np.ones(len(u)),
    )


BLOCKS = recon.ImageMatcher(match=match)
