"""Videos: flicker and throughput."""
