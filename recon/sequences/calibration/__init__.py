"""Calibrations: reading, estimation from boards, refinement from the images."""
