"""Fitting of solids to points by robust geometric distance."""
