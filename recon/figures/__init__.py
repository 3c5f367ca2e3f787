"""Images of what was found: one kind a file, records in, images (H, W, 3) out."""
