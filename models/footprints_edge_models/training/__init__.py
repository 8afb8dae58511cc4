"""Training: recipe, losses, batches, the loop, validation, plots, ablations."""
