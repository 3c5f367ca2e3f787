"""Readers of recordings: one format per file."""
