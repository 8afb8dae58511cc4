"""Visualisation: overlays, bird's-eye views and path pictures."""
