"""Shading: from what rays meet to linear light."""
