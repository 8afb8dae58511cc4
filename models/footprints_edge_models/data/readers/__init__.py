"""Readers of training data, one layout a file: a folder to samples."""
