"""The thesis beside recon: one entry per figure and table of its own work."""
