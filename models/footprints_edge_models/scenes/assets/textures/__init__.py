"""Textures: procedural patterns and crops of photos."""
