"""Losses, batches, the training loop and its validation."""
