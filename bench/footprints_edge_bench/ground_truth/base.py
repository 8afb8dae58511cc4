"""What is truly known of an image, and a dataset of such images."""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from footprints_edge.errors import FootprintsError
from footprints_edge.foundation.types import Floats, Mask, Size
from footprints_edge.geometry.camera import Intrinsics
from footprints_edge_bench.geometry.boxes import Box
from footprints_edge_bench.geometry.voxels import VoxelGrid


class GroundTruthError(FootprintsError):
    """Data to evaluate on is missing or not laid out as expected."""


@dataclass(frozen=True, eq=False)
class LabelledMask:
    """A true mask and where it is known.

    Attributes:
        mask: bool (H, W); False where unknown.
        valid: bool (H, W); what is not known is not scored.
    """

    mask: Mask
    valid: Mask


@dataclass(frozen=True, eq=False)
class GroundTruth:
    """The ground truth of one image; None is what a dataset does not know. All maps are (H, W).

    Attributes:
        image: the picture's file.
        size: (H, W) of the maps, at which predictions are judged.
        intrinsics: the camera in pixels of the picture.
        visible_ground: the paper's S.
        ground: the paper's S*.
        visible_depth_m: float32, metres along the optical axis, 0 where unknown: D.
        ground_depth_m: float32, metres along the optical axis, 0 where unknown: D*.
        region: bool, where footprints are judged.
        boxes: things in the image, for the box baseline.
        voxels: the scene in voxels, for the voxel baselines.
    """

    image: Path
    size: Size
    intrinsics: Intrinsics | None = None
    visible_ground: LabelledMask | None = None
    ground: LabelledMask | None = None
    visible_depth_m: Floats | None = None
    ground_depth_m: Floats | None = None
    region: Mask | None = None
    boxes: tuple[Box, ...] | None = None
    voxels: VoxelGrid | None = None


@dataclass(frozen=True)
class Item:
    """One image of a dataset, not read yet.

    Attributes:
        name: unique among all datasets of a run: the dataset's name, a slash, the image's.
        load: reads its ground truth.
    """

    name: str
    load: Callable[[], GroundTruth] = field(repr=False)


@dataclass(frozen=True)
class EvaluationDataset:
    """Images whose ground truth has one source.

    Attributes:
        name: of the folder.
        kind: which reader it is from.
        items: in order.
    """

    name: str
    kind: str
    items: tuple[Item, ...]
