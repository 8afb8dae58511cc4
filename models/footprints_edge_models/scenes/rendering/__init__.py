"""Renders a scene into a photo."""
