"""Recorded sequences: readers of many formats, calibration, rectification, odometry."""

from recon.sequences.open import open_sequence
from recon.sequences.truth import read_truth, read_truth_file

__all__ = ["open_sequence", "read_truth", "read_truth_file"]
