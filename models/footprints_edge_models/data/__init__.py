"""Training data: readers, splits, the mixture, augmentation."""
