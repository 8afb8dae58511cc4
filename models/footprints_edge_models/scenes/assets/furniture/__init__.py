"""Furniture and what stands on it. Every maker gives a thing whose front looks along -y."""
