"""Stereo by the phase of oriented filters at several scales (thesis chapter 3)."""
