"""Model files and images to measure with: converted and cached, or synthetic."""
