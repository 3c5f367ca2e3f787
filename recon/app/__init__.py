"""Pages in a browser: the simulator and the inspector."""
