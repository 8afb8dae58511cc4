"""What is exactly known of a scene: ground, boxes, voxels."""
