"""Videos, cameras and pipes: capture, smoothing, overlays and output files."""
