"""The PyTorch networks of footprints-edge, their losses, training data and training."""
