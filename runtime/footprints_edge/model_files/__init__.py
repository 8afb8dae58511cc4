"""Model files: their registry and their metadata."""
