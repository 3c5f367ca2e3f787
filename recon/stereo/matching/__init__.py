"""Matching: cost, aggregation, and the matchers."""
