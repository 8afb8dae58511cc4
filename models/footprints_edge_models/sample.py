"""One training sample: a picture and what is known of its four maps."""

from dataclasses import dataclass
from typing import TypeVar

import cv2
import numpy as np
from numpy.typing import NDArray

from footprints_edge.geometry.camera import Intrinsics

NO, YES, UNSEEN, FOOTPRINT, UNKNOWN = 0, 1, 2, 3, 255
"""Label values: known not to be ground; known to be; watched but never seen (the paper's prior
applies, eq. 3c); known not to be, for a thing stands on that very spot (its footprint); nothing
known."""

LONGEST_SIDE_PX = 512
"""Pictures are kept no larger than this: the network sees about 448."""

ScalarT = TypeVar("ScalarT", bound=np.generic)


@dataclass(frozen=True)
class Sample:
    """A picture with its labels, all of the same (H, W).

    Attributes:
        name: source and frame, for messages.
        image: uint8 (H, W, 3), RGB.
        intrinsics: the camera, in pixels of this picture; assumed where nobody measured it.
        visible_ground: uint8 (H, W): NO, YES or UNKNOWN.
        ground: uint8 (H, W): NO or FOOTPRINT (untraversable), YES (traversable), UNSEEN
            or UNKNOWN.
        visible_depth_m: float16 (H, W), metres along the optical axis, 0 = unknown; or None.
        ground_depth_m: float16 (H, W), likewise, of the walkable surface on the ray; or None.
        moving: uint8 (H, W), 1 where a moving object hides whatever ground there is; or None.
    """

    name: str
    image: NDArray[np.uint8]
    intrinsics: Intrinsics
    visible_ground: NDArray[np.uint8]
    ground: NDArray[np.uint8]
    visible_depth_m: NDArray[np.float16] | None = None
    ground_depth_m: NDArray[np.float16] | None = None
    moving: NDArray[np.uint8] | None = None


def shrunk(sample: Sample) -> Sample:
    """The sample with its longest side at most ``LONGEST_SIDE_PX``."""
    height, width = sample.image.shape[:2]
    size = within((height, width))
    if size == (height, width):
        return sample

    def resized(array: NDArray[ScalarT] | None) -> NDArray[ScalarT] | None:
        return None if array is None else nearest(array, size)

    return Sample(
        sample.name,
        cv2.resize(sample.image, size[::-1], interpolation=cv2.INTER_AREA),
        sample.intrinsics.scaled((height, width), size),
        nearest(sample.visible_ground, size),
        nearest(sample.ground, size),
        resized(sample.visible_depth_m),
        resized(sample.ground_depth_m),
        resized(sample.moving),
    )


def within(size: tuple[int, int], longest_px: int = LONGEST_SIDE_PX) -> tuple[int, int]:
    """(H, W) with the same aspect and no side longer than ``longest_px``."""
    scale = longest_px / max(size)
    return size if scale >= 1 else (round(size[0] * scale), round(size[1] * scale))


def nearest(array: NDArray[ScalarT], size: tuple[int, int]) -> NDArray[ScalarT]:
    """Labels (h, w) at another size (H, W): the label under each pixel's centre."""
    height, width = array.shape
    if (height, width) == size:
        return array
    rows = ((np.arange(size[0]) + 0.5) * height / size[0]).astype(int)[:, None]
    columns = ((np.arange(size[1]) + 0.5) * width / size[1]).astype(int)
    resized: NDArray[ScalarT] = array[rows, columns]
    return resized
