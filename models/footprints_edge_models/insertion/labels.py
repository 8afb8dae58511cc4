"""The labels of photos with models in them: the photo's class ids, and what the models changed.

A pixel that shows a model keeps the id of what is behind it, plus ``MODEL``. Where a model stands,
``TAKEN`` takes the place of the floor's id.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

MODEL, TAKEN = 100, 200
"""Ids of classes are below both."""


@dataclass(frozen=True)
class InsertedLabels:
    """What is where in a photo with models in it, all (H, W).

    Attributes:
        ids: uint8, class ids of the photo without the models; on ``taken`` some floor's.
        shows_model: bool, where a model is seen.
        taken: bool, floor that the models stand on.
    """

    ids: NDArray[np.uint8] = field(repr=False)
    shows_model: NDArray[np.bool_] = field(repr=False)
    taken: NDArray[np.bool_] = field(repr=False)

    def encoded(self) -> NDArray[np.uint8]:
        """One label picture, uint8 (H, W)."""
        labels = self.ids + np.uint8(MODEL) * self.shows_model
        labels[self.taken] = TAKEN
        return labels


def decoded(labels: NDArray[np.uint8], floor: int) -> InsertedLabels:
    """The labels of a label picture.

    Args:
        labels: uint8 (H, W).
        floor: id that ``taken`` pixels get: whose floor it was is not kept.
    """
    taken = labels == TAKEN
    ids = np.where(taken, floor, labels % MODEL).astype(np.uint8)
    return InsertedLabels(ids, (labels >= MODEL) | taken, taken)
