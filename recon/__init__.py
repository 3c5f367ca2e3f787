"""recon reconstructs objects from stereo sequences."""

__version__ = "0.1.0"
