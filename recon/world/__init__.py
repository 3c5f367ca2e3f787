"""The simulated world: geometry files, renderers, and what is true in it."""
