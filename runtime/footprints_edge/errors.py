"""Every error that this package raises on purpose: what happened, with which value, what to do."""


class FootprintsError(Exception):
    """Base of all errors of footprints-edge; catching it catches every one below."""


class ImageError(FootprintsError):
    """An input is no usable picture: not an image, truncated, empty, hostile, of a wrong dtype."""


class IntrinsicsError(FootprintsError):
    """Camera intrinsics or a field of view that no camera has."""


class ModelError(FootprintsError):
    """A model is unknown, damaged, foreign to the file contract, or cannot run here."""


class OutputError(FootprintsError):
    """A result cannot be written: unknown format, file in the way, no such folder."""
