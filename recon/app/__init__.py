"""Web pages: the simulator and the inspector."""
