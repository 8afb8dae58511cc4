"""Model files: which there are, and what they say about themselves."""
