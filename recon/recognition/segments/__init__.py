"""Segments: which cells belong to one object, and to one part of it."""
