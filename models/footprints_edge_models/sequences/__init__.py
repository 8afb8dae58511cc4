"""Sequences of a moving camera: readers of every layout of frames with poses."""
