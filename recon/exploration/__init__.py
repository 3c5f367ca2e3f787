"""The agent that walks, looks, maps, and stops when all is known."""
