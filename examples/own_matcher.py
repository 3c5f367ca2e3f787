"""Reconstruct a recording with your own matcher: python own_matcher.py SEQUENCE."""

import sys

import cv2
import numpy as np

import recon


def match(left: recon.Image, right: recon.Image, s: recon.MatchingSettings) -> recon.Matches:
    blocks = cv2.StereoBM.create(numDisparities=16 * (s.max_disparity // 16 + 1), blockSize=11)
    greys = (cv2.cvtColor(image, cv2.COLOR_RGB2GRAY) for image in (left, right))
    found = np.asarray(blocks.compute(*greys), float) / 16
    v, u = np.nonzero(found > 0)
    points, ones = np.column_stack([u, v]).astype(float), np.ones(len(u))
    return recon.Matches(points_px=points, disparity_px=found[v, u], sigma_px=ones / 3, score=ones)


recon.register("matchers", "blocks", recon.ImageMatcher(match=match))
print(recon.reconstruct(sys.argv[1], matcher="blocks"))
