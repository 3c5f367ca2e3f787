"""Descriptions: a few facts about any file or folder that recon reads or writes."""

from recon.runs.description.description import describe

__all__ = ["describe"]
