"""How far a file may be from the one it was made from."""

import numpy as np

from footprints_edge_export.errors import VerificationError
from footprints_edge_export.verification.compare import Difference

BOUNDS = {"fp16": (0.99, 0.01), "ort of fp32": (0.999, 0.001), "ort of int8": (0.98, 0.05)}
"""Least IoU of a mask and largest mean relative difference of the visible depths: of fp16 weights
against float32, and of an ``.ort`` file against its model."""


def check_bounds(kind: str, difference: Difference) -> None:
    """Refuse a difference beyond its bounds.

    Args:
        kind: key of ``BOUNDS``.
        difference: the file against the one it was made from.

    Raises:
        VerificationError: the masks or the depths differ too much.
    """
    least_iou, most_abs_rel = BOUNDS[kind]
    worst = min(difference.visible_ground_iou, difference.ground_iou)
    if worst < least_iou or not difference.visible_depth_abs_rel <= most_abs_rel:
        raise VerificationError(
            f"{kind} changes the masks (IoU {worst:.4f}, at least {least_iou:g}) or the depths (by "
            f"{difference.visible_depth_abs_rel:.2g} of the distance, at most {most_abs_rel:g}) "
            "too much; no file was written"
        )


def check_finite(difference: Difference) -> None:
    """Refuse an int8 file whose maps are not numbers.

    Raises:
        VerificationError: a map has NaN or infinity.
    """
    if not np.isfinite(list(difference.max_abs.values())).all():
        raise VerificationError("the int8 model gives maps that are not finite; no file written")
