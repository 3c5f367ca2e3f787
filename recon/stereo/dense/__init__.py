"""Dense disparity: planes over superpixels."""
