"""Why an export was refused."""

from footprints_edge.errors import FootprintsError


class ExportError(FootprintsError):
    """A conversion cannot be done as asked: no such option, too few photos, file in the way."""


class VerificationError(FootprintsError):
    """A converted model is not what it was converted from; no file was left behind."""
