"""What the graph passes gain in speed, and what they change in the maps."""
