"""Navigation on the maps: ground flattening, occupancy grids, path planning."""
