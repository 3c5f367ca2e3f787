"""Localisation: the pose of a pair in a known map, and the recognition of known places."""
