"""Whole runs: the stages, the run folder and the figures together; what every door calls."""
