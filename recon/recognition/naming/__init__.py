"""Naming: which kind of the catalogue an object is, and how probable that is."""
