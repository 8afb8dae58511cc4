"""One training sample: a picture and what is known of its four maps."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from footprints_edge.geometry import Intrinsics

NO, YES, UNSEEN, UNKNOWN = 0, 1, 2, 255
"""Label values: known not to be ground; known to be; watched but never seen (the paper's prior
applies, eq. 3c); nothing known."""


@dataclass(frozen=True)
class Sample:
    """A picture with its labels, all of the same (H, W).

    Attributes:
        name: source and frame, for messages.
        image: uint8 (H, W, 3), RGB.
        intrinsics: the camera, in pixels of this picture; assumed where nobody measured it.
        visible_ground: uint8 (H, W): NO, YES or UNKNOWN.
        ground: uint8 (H, W): NO (untraversable), YES (traversable), UNSEEN or UNKNOWN.
        visible_depth_m: float16 (H, W), metres along the optical axis, 0 = unknown; or None.
        ground_depth_m: float16 (H, W), likewise, of the walkable surface on the ray; or None.
    """

    name: str
    image: NDArray[np.uint8]
    intrinsics: Intrinsics
    visible_ground: NDArray[np.uint8]
    ground: NDArray[np.uint8]
    visible_depth_m: NDArray[np.float16] | None = None
    ground_depth_m: NDArray[np.float16] | None = None
