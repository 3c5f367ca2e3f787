"""The loop from pairs to the map: one pair, and all pairs of a recording or an exploration."""
