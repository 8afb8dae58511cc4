"""Boxes, voxels and convex hulls that the baselines need."""
