"""The only module that knows OpenCV: what video needs of it comes with the extra `video`."""

from typing import Any

from footprints_edge.errors import VideoError


def opencv() -> Any:  # noqa: ANN401 - its own stubs type every array as "integer or floating"
    """The module `cv2`.

    Raises:
        VideoError: If it is not installed.
    """
    try:
        import cv2
    except ModuleNotFoundError as error:
        raise VideoError(
            f"videos and cameras need the package {error.name}; install it with: "
            "pip install 'footprints-edge[video]'"
        ) from None
    return cv2
