"""What a robot does with the maps: ground plane, occupancy grid, paths."""
