"""Errors of an export."""

from footprints_edge.errors import FootprintsError, ModelError


class ExportError(FootprintsError):
    """The conversion cannot be done as asked: a bad option, too few photos, an existing file."""


class VerificationError(ModelError):
    """A converted model differs from its source or breaks the contract; no file is left behind."""
