"""Recognition: from occupied cells, or any cloud, to named objects."""
