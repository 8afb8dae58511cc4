"""The networks, their channels, their checkpoints and their registry."""
