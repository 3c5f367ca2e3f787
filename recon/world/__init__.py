"""The simulated world: geometry files, renderers and ground truth."""
