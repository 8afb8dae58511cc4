"""What masks are calibrated on: held-out pictures, in two halves that show different places."""

from collections.abc import Sequence
from pathlib import Path
from typing import TypeAlias

from footprints_edge_models.data.errors import DatasetError
from footprints_edge_models.data.mixture import (
    DATASETS,
    VIDEO_LABELS,
    TrainingDataset,
    load_dataset,
)
from footprints_edge_models.data.readers.hand_drawn import is_hand_drawn, read_hand_drawn
from footprints_edge_models.data.splits import halves_cut
from footprints_edge_models.sample import Sample
from footprints_edge_models.training.validation import spread
from footprints_edge_models.video_labels.files import ABOUT

Halves: TypeAlias = tuple[Sequence[Sample], Sequence[Sample]]
"""Pictures to fit on, and others to score the fit on."""


def halves_of(folder: Path) -> Halves:
    """Both halves of one dataset.

    It is one that training knows by name, video labels, or photos with hand-drawn ground. Of those
    all are taken: no network is trained on them.

    Raises:
        DatasetError: it is none of these, or not laid out as expected.
    """
    folder = folder.resolve()
    if folder.name in DATASETS:
        return halved(load_dataset(folder, DATASETS[folder.name]))
    if (folder / ABOUT).is_file():
        return halved(load_dataset(folder, VIDEO_LABELS))
    if is_hand_drawn(folder):
        photos = list(read_hand_drawn(folder))  # each of another place, of one kind after another
        return photos[::2], photos[1::2]
    raise DatasetError(
        f"{folder}: no photos with hand-drawn ground (images/ and truth.json), and none of "
        f"{', '.join(DATASETS)}"
    )


def halved(dataset: TrainingDataset) -> Halves:
    """The held-out pictures, at most 40 evenly spread, in two halves without a place in common."""
    samples = [*spread(dataset.held_out)]
    cut = halves_cut([sample.name for sample in samples], dataset.views)
    return samples[:cut], samples[cut:]
