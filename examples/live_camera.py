"""Map what a stereo camera sees, images side by side: python live_camera.py CALIB CAMERA."""

import sys

import cv2
import numpy as np

import recon

source = sys.argv[2]  # a number, or a file
camera = cv2.VideoCapture(int(source)) if source.isdecimal() else cv2.VideoCapture(source)
is_read, frame = camera.read()
half = frame.shape[1] // 2
rectify = recon.rectifier(sys.argv[1], size=(half, frame.shape[0]))
mapper = recon.Mapper(recon.Settings.of(quality="fast"))
while is_read:
    both = np.ascontiguousarray(frame[..., ::-1], np.uint8)  # OpenCV has BGR
    print(mapper.process(rectify.pair(both[:, :half], both[:, half:])))
    is_read, frame = camera.read()
