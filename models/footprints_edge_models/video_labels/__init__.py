"""Training labels of a moving camera's frames, and the jobs that make them."""
