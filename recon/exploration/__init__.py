"""The agent that walks, looks, maps, and stops when everything is known."""
