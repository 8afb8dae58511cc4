"""Datasets with ground truth, one file per kind."""
