"""Naming: the kind of the catalogue that an object is, with a probability."""
