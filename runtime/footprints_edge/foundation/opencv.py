"""The only module that imports OpenCV, which comes with the extra `video`."""

from typing import Any

from footprints_edge.errors import VideoError
from footprints_edge.foundation.install_hint import install_hint


def opencv() -> Any:  # noqa: ANN401 - its own stubs type every array as "integer or floating"
    """The module `cv2`.

    Raises:
        VideoError: If it is not installed.
    """
    try:
        import cv2
    except ModuleNotFoundError as error:
        raise VideoError(
            f"videos and cameras need the package {error.name}; {install_hint('video')}"
        ) from None
    return cv2
