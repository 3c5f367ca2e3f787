"""Localisation: the pose of a pair in a known map, and the places that a robot knows again."""
