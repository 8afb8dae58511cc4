"""The ground truth of one image, and a dataset of such images."""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from footprints_edge.errors import FootprintsError
from footprints_edge.foundation.types import Floats, Mask, Size
from footprints_edge.geometry.camera import Intrinsics
from footprints_edge_bench.geometry.boxes import Box
from footprints_edge_bench.geometry.voxels import VoxelGrid


class GroundTruthError(FootprintsError):
    """A dataset is missing or is not laid out as expected."""


@dataclass(frozen=True, eq=False)
class LabelledMask:
    """A mask of the ground truth and where it is valid.

    Attributes:
        mask: bool (H, W); False where it is not valid.
        valid: bool (H, W); pixels outside are not scored.
    """

    mask: Mask
    valid: Mask


@dataclass(frozen=True, eq=False)
class GroundTruth:
    """The ground truth of one image; None where the dataset has none. All maps are (H, W).

    Attributes:
        image: the image file.
        size: (H, W) of the maps, at which predictions are scored.
        intrinsics: the camera, in pixels of the image.
        visible_ground: the paper's S.
        ground: the paper's S*.
        visible_depth_m: the paper's D, float32, metres along the optical axis, 0 where unknown.
        ground_depth_m: the paper's D*, float32, metres along the optical axis, 0 where unknown.
        region: bool, where footprints are scored.
        boxes: objects in the image, for the box baseline.
        voxels: the scene in voxels, for the voxel baselines.
        footprints: bool, ground that things take, wherever it is.
        false_depth: finds where other frames refute `visible_depth_m`, bool.
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
    footprints: Mask | None = None
    false_depth: Callable[[], Mask] | None = None


@dataclass(frozen=True)
class Item:
    """One image of a dataset; its ground truth is read on demand.

    Attributes:
        name: dataset name, slash, image name; unique among all datasets of a run.
        load: reads the ground truth.
        files: the files that the ground truth is read from, in a fixed order.
    """

    name: str
    load: Callable[[], GroundTruth] = field(repr=False)
    files: tuple[Path, ...] = field(default=(), repr=False)


@dataclass(frozen=True)
class EvaluationDataset:
    """Images with ground truth from one folder.

    Attributes:
        name: name of the folder.
        kind: key of ``datasets.KINDS``.
        items: the images, in order.
    """

    name: str
    kind: str
    items: tuple[Item, ...]
