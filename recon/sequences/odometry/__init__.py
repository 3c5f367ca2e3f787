"""Stereo visual odometry: points tracked, motions between pairs, a path."""
