"""Views of panoramas on which a person drew the ground, seen and hidden."""

from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from footprints_edge_bench.ground_truth.base import GroundTruth, Item, LabelledMask

if TYPE_CHECKING:
    from footprints_edge_models.panoramas.files import ViewFile


def is_panorama_folder(folder: Path) -> bool:
    """Whether a folder holds views of panoramas."""
    return (folder / "panoramas.json").is_file()


def read_panoramas(folder: Path) -> Iterator[Item]:
    """The views of a folder that ``fp-train panoramas`` wrote.

    Raises:
        PanoramaError: it was not finished, or another version wrote it.
    """
    from footprints_edge_models.panoramas.files import read_views

    for view in read_views(folder):
        yield Item(view.name, partial(_load, view), (view.labels, folder / "panoramas.json"))


def _load(view: "ViewFile") -> GroundTruth:
    from footprints_edge_models.panoramas.labels import (
        FOOTPRINT,
        GROUND,
        IGNORED,
        VISIBLE_GROUND,
    )

    bits = view.read_bits()
    ground, footprints, valid = bits & GROUND > 0, bits & FOOTPRINT > 0, bits & IGNORED == 0
    return GroundTruth(
        view.image,
        (bits.shape[0], bits.shape[1]),
        view.intrinsics,
        visible_ground=LabelledMask(bits & VISIBLE_GROUND > 0, valid),
        ground=LabelledMask(ground, valid),
        region=ground | footprints,
        footprints=footprints,
    )
