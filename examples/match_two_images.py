"""Match two rectified images: python match_two_images.py LEFT RIGHT [MAX_DISPARITY]."""

import sys

import numpy as np
from skimage.io import imread

import recon

left, right = (np.asarray(imread(path), np.uint8) for path in sys.argv[1:3])
matches = recon.match_pair(left, right, max_disparity=int(sys.argv[3]) if sys.argv[3:] else 64)
sure = matches.select(matches.sigma_px < 0.1)
print(matches, "of which", len(sure), "are sure to a tenth of a pixel")
