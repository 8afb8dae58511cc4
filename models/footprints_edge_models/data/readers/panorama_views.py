"""Views of panoramas that ``fp-train panoramas`` cut out, with hand-drawn ground."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from footprints_edge.inputs.images import decode
from footprints_edge_models.data.errors import DatasetError
from footprints_edge_models.panoramas import labels
from footprints_edge_models.panoramas.files import read_views
from footprints_edge_models.sample import FOOTPRINT, NO, UNKNOWN, YES, Sample


def read_panorama_views(folder: Path) -> Iterator[Sample]:
    """The views of a folder: S and S* are labelled everywhere but where nobody can decide.

    Depths are unknown: so is the height of the cameras.

    Raises:
        PanoramaError: the folder was not finished, or labels are damaged.
        DatasetError: a picture and its labels differ in size.
    """
    for view in read_views(folder):
        bits, image = view.read_bits(), decode(view.image).rgb
        if image.shape[:2] != bits.shape:
            raise DatasetError(f"{view.labels}: labels are {bits.shape}, not as the picture")
        ignored = bits & labels.IGNORED > 0
        visible = np.where(bits & labels.VISIBLE_GROUND > 0, YES, NO)
        ground = np.select(
            [bits & labels.GROUND > 0, bits & labels.FOOTPRINT > 0], [YES, FOOTPRINT], NO
        )
        yield Sample(
            f"{folder.name}/{view.name}",
            image,
            view.intrinsics,
            np.where(ignored, UNKNOWN, visible).astype(np.uint8),
            np.where(ignored, UNKNOWN, ground).astype(np.uint8),
        )
