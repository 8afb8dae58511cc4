"""The model files that are measured, and pictures to feed them."""
