"""Surfaces: depth maps confirmed by their neighbours, fused into one mesh."""
