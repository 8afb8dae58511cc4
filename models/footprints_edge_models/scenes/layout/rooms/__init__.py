"""Furnished rooms on a floor plan."""
