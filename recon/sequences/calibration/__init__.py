"""Calibrations: read, estimated from boards, refined from the images."""
