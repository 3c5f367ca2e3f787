"""Fitting: solids through points by robust geometric distance."""
