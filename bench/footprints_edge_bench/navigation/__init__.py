"""How good paths and occupancy grids are."""
