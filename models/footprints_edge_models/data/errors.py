"""Errors of training data."""

from footprints_edge.errors import FootprintsError


class DatasetError(FootprintsError):
    """Training data is missing or not laid out as expected."""
