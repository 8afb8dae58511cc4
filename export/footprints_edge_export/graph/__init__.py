"""Graphs from PyTorch, and their input, weights and file format."""
