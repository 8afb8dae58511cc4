"""Why an export was refused."""

from footprints_edge.errors import FootprintsError, ModelError


class ExportError(FootprintsError):
    """A conversion cannot be done as asked: no such option, too few photos, file in the way."""


class VerificationError(ModelError):
    """A converted model is not what it was converted from; no file was left behind."""
