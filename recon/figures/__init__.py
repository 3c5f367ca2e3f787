"""Figures of the results: one kind per file, records in, images (H, W, 3) out."""
