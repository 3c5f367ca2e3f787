"""Stereo visual odometry: tracked points, motions between pairs, trajectory errors."""
