"""Every error that this package raises on purpose: what happened, with which value, what to do."""


class FootprintsError(Exception):
    """Base of all errors of footprints-edge; catching it catches every one below."""


class ImageError(FootprintsError):
    """An input is no usable picture: not an image, truncated, empty, hostile, of a wrong dtype."""


class IntrinsicsError(FootprintsError):
    """Camera intrinsics or a field of view that no camera has."""


class ModelError(FootprintsError):
    """A model is unknown, damaged, foreign to the file contract, or cannot run here."""


class MissingMapError(FootprintsError, AttributeError):
    """A map was read that the model file does not have: one without masks, or without depths."""


class OutputError(FootprintsError):
    """A result cannot be written: unknown format, file in the way, no such folder."""


class GroundPlaneError(FootprintsError):
    """No plane can be fitted to the ground: too little of it, in one line, above the camera."""


class PlanningError(FootprintsError):
    """Base of what keeps a path from being planned; the ones below say which."""


class OutsideError(PlanningError):
    """A start or goal is outside the picture."""


class OffGroundError(PlanningError):
    """A start or goal is not on the ground, or too near to an obstacle for the margin."""


class NoPathError(PlanningError):
    """Start and goal are on the ground, but no way on the ground joins them."""


class VideoError(FootprintsError):
    """A video or camera cannot be opened or read on, or OpenCV is missing."""
