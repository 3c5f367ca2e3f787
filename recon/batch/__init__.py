"""Batches: many jobs on many processes or machines, each with its own run folder."""
