"""One training sample: an image and the labels of its four maps, as far as they are known."""

from dataclasses import dataclass
from typing import TypeVar

import cv2
import numpy as np
from numpy.typing import NDArray

from footprints_edge.geometry.camera import Intrinsics

NO, YES, UNSEEN, FOOTPRINT, UNKNOWN = 0, 1, 2, 3, 255
"""Label values: not ground; ground; watched by a video, but no frame saw ground there (the paper's
eq. 3c applies); the footprint of an object, on which nobody can walk; no label."""

LONGEST_SIDE_PX = 512
"""Images are shrunk to this: the network sees about 448 pixels."""

ScalarT = TypeVar("ScalarT", bound=np.generic)


@dataclass(frozen=True)
class Sample:
    """An image with its labels, all of the same (H, W).

    Attributes:
        name: dataset and frame.
        image: uint8 (H, W, 3), RGB.
        intrinsics: of the camera, in pixels of this image; assumed where they were not measured.
        visible_ground: uint8 (H, W): NO, YES or UNKNOWN.
        ground: uint8 (H, W): NO or FOOTPRINT (untraversable), YES (traversable), UNSEEN or UNKNOWN.
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
    """The sample, its longest side shrunk to at most ``LONGEST_SIDE_PX``."""
    return sample_at(sample, within((sample.image.shape[0], sample.image.shape[1])))


def sample_at(sample: Sample, size: tuple[int, int]) -> Sample:
    """The sample at a smaller (H, W)."""
    height, width = sample.image.shape[:2]
    if size == (height, width):
        return sample

    def smaller(array: NDArray[ScalarT] | None) -> NDArray[ScalarT] | None:
        return None if array is None else nearest(array, size)

    return Sample(
        sample.name,
        cv2.resize(sample.image, size[::-1], interpolation=cv2.INTER_AREA),
        sample.intrinsics.scaled((height, width), size),
        nearest(sample.visible_ground, size),
        nearest(sample.ground, size),
        smaller(sample.visible_depth_m),
        smaller(sample.ground_depth_m),
        smaller(sample.moving),
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
