"""Segments: the cells of each object and of each part."""
