"""Contradictions between what a recording says of itself and what its images show."""
