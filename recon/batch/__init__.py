"""Batches: many jobs on many processes or machines, each in a run folder of its own."""
