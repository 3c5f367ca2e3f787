"""Descriptions: what a file or folder is, in a few facts, for whatever recon reads or writes."""

from recon.runs.description.description import describe

__all__ = ["describe"]
