"""Cameras, points and the ground plane."""
