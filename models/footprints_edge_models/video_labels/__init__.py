"""Training labels made from video, and the job that makes them."""
