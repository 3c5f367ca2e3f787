"""Contradictions between the metadata of a recording and its images."""
