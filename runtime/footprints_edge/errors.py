"""The package's exceptions. A message says what happened, with which value, and what to do."""


class FootprintsError(Exception):
    """Base class of all errors of footprints-edge."""


class ImageError(FootprintsError):
    """An input is not a usable picture: not an image, truncated, empty, hostile, or wrong dtype."""


class IntrinsicsError(FootprintsError):
    """Camera intrinsics or a field of view are impossible."""


class CameraPoseError(FootprintsError):
    """A camera's height, pitch, roll or gravity is impossible, or contradicts another."""


class ModelError(FootprintsError):
    """A model is unknown, damaged, breaks the file contract, or cannot run here."""


class MissingMapError(FootprintsError, AttributeError):
    """The model file lacks the map that was read: it has no masks, or no depths."""


class OutputError(FootprintsError):
    """A result cannot be written: unknown format, existing file, no such folder."""


class GroundPlaneError(FootprintsError):
    """There is no ground plane: too little ground, uneven ground, or a plane that cannot be.

    Attributes:
        reason: `no_ground` if the picture shows none, `panorama` if it is one; `few_pixels`,
            `one_line` or `above_camera` if no plane fits; `little_ground`, `impossible_pose` or
            `not_flat` if the one that fits is refused.
    """

    def __init__(self, message: str, reason: str = "") -> None:
        super().__init__(message)
        self.reason = reason


class PlanningError(FootprintsError):
    """A path cannot be planned. Base class of the more specific reasons below."""


class OutsideError(PlanningError):
    """The start or the goal is outside the picture."""


class OffGroundError(PlanningError):
    """The start or the goal is not on the ground, or closer to an obstacle than the margin."""


class NoPathError(PlanningError):
    """The start and the goal are on the ground, but no path over the ground connects them."""


class BagError(FootprintsError):
    """A ROS bag cannot be read or written, shows no picture, or rosbags is missing."""


class VideoError(FootprintsError):
    """A video or camera cannot be opened or read, or OpenCV is missing."""
