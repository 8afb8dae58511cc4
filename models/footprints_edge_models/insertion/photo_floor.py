"""The floor that a photo shows, and the camera that took it as the floor tells it."""

from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from footprints_edge.errors import FootprintsError, GroundPlaneError
from footprints_edge.geometry.camera import Intrinsics
from footprints_edge.model import Model
from footprints_edge_models.insertion.labels import MODEL
from footprints_edge_models.scenes.rendering.cameras import Camera
from footprints_edge_models.sequences.folders import WALKABLE

SKY, ROAD = 3, 7
"""Ids of ADE20K's 31 most frequent classes."""
LEAST_FLOOR = 0.05
"""Least share of a photo that is floor."""
AGREED = 0.65
"""Least share of the labelled floor on which the model sees ground, too: labels err."""
_SURELY, _PERHAPS = 0.4, 0.3
_OUTDOORS = 0.06


class InsertionError(FootprintsError):
    """Nothing can be put into a photo; the message says why."""


@dataclass(frozen=True)
class PhotoFloor:
    """A photo, its labels, and its floor as level ground at z = 0.

    Attributes:
        image: uint8 (H, W, 3), RGB.
        ids: uint8 (H, W), class ids.
        mask: bool (H, W), floor that is surely seen.
        camera: above the origin, looking along +y.
        outdoors: whether sky or a road is seen.
    """

    image: NDArray[np.uint8] = field(repr=False)
    ids: NDArray[np.uint8] = field(repr=False)
    mask: NDArray[np.bool_] = field(repr=False)
    camera: Camera
    outdoors: bool

    @property
    def walkable(self) -> NDArray[np.bool_]:
        """Bool (H, W), all that is labelled as floor."""
        return np.isin(self.ids, WALKABLE)


def find_floor(image: NDArray[np.uint8], ids: NDArray[np.uint8], model: Model) -> PhotoFloor:
    """The floor of a photo, by its labels and by a model, which also knows its plane.

    Raises:
        InsertionError: there is too little floor, the two disagree, or no plane is found.
    """
    if ids.max() >= MODEL:
        raise InsertionError(
            f"class id {ids.max()}: ids are those of ADE20K's frequent classes, below "
            f"{MODEL}, as fp-train photos writes them"
        )
    height, width = ids.shape
    camera = Intrinsics.assumed((height, width))
    prediction = model.predict(image, intrinsics=camera)
    try:
        plane = prediction.ground_plane()
    except GroundPlaneError as error:
        raise InsertionError(str(error)) from error
    probability = np.asarray(prediction.visible_ground_probability, np.float32)
    probability = cv2.resize(probability, (width, height))
    labelled = np.isin(ids, WALKABLE)
    if (labelled & (probability > _PERHAPS)).sum() < AGREED * max(int(labelled.sum()), 1):
        raise InsertionError("labels and model disagree about the floor")
    sure = (labelled & (probability > _SURELY)).astype(np.uint8)
    mask = cv2.erode(sure, np.ones((3, 3), np.uint8)) > 0
    if mask.mean() < LEAST_FLOOR:
        raise InsertionError("too little floor")
    ahead, left, up = plane.axes
    pose = np.stack([-left, ahead, up])
    place = Camera(np.array([0, 0, plane.camera_height_m]), pose, camera, (height, width))
    return PhotoFloor(image, ids, mask, place, bool(np.isin(ids, (SKY, ROAD)).mean() > _OUTDOORS))
