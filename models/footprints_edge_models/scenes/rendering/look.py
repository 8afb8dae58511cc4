"""How much work goes into pictures, and what takes them."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from footprints_edge_models.scenes.assets.textures.library import TextureLibrary
from footprints_edge_models.scenes.rendering.phone import take_photo
from footprints_edge_models.scenes.rendering.sensor import photograph

TakePicture = Callable[[NDArray[np.float32], np.random.Generator], NDArray[np.uint8]]


@dataclass(frozen=True)
class Look:
    """The look of pictures. Scenes without assets keep theirs, byte for byte.

    Attributes:
        supersampling: colours are computed at this many pixels for each of the picture's, along
            each side.
        bounced: whether light comes from where it comes from, sky and surfaces around; otherwise
            it is the same from all sides.
        photograph: turns linear light (H, W, 3) into a photo, uint8 RGB.
    """

    supersampling: float
    bounced: bool
    photograph: TakePicture


PLAIN = Look(1.1, False, photograph)
PHOTO = Look(1.25, True, take_photo)


def look_of(library: TextureLibrary) -> Look:
    """Scenes that are furnished from a pack of assets look like photos of a phone."""
    return PLAIN if library.pictures is None else PHOTO
