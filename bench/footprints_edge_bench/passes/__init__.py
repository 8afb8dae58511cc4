"""What the graph passes gain, and what they change."""
