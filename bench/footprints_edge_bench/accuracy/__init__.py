"""Accuracy of models and of the paper's baselines."""
