"""Oriented boxes, voxel grids and convex hulls, for the baselines."""
