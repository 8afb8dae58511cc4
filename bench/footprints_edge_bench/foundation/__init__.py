"""Building blocks that every other folder may use."""
