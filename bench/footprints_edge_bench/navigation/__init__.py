"""Path planning and occupancy grids against ground truth."""
