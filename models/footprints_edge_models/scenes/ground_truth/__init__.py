"""Exact ground truth of a scene: pixels, boxes, voxels."""
