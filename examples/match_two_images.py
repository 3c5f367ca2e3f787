"""Match two rectified images: python match_two_images.py LEFT RIGHT MAX_DISPARITY."""

import sys

import numpy as np
from PIL import Image

import recon

left, right = (np.asarray(Image.open(path).convert("RGB")) for path in sys.argv[1:3])
matches = recon.match_pair(left, right, max_disparity=int(sys.argv[3]))
print(f"{matches}, half of them surer than {np.median(matches.sigma_px):.3f} px")
