"""Scores of every method on one image."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass

from footprints_edge.prediction import Prediction
from footprints_edge_bench.accuracy import metrics
from footprints_edge_bench.accuracy.baselines import Estimate, baselines, estimate_of
from footprints_edge_bench.accuracy.metrics import DepthScores, MaskCounts, number_or_none
from footprints_edge_bench.geometry.boxes import Box
from footprints_edge_bench.geometry.voxels import VoxelGrid
from footprints_edge_bench.ground_truth.base import GroundTruth


@dataclass(frozen=True)
class MethodScores:
    """Scores of one method on one image; None where the method or the ground truth has no map.

    Attributes:
        freespace: S* over the image.
        footprint: pixels that are not S*, in the footprint region.
        visible_ground: S over the image.
        ground_depth: D*, the paper's hidden depth.
        visible_depth: D.
    """

    freespace: MaskCounts | None = None
    footprint: MaskCounts | None = None
    visible_ground: MaskCounts | None = None
    ground_depth: DepthScores | None = None
    visible_depth: DepthScores | None = None

    def as_json(self) -> dict[str, dict[str, float] | None]:
        """Plain values, as :meth:`from_json` takes them."""
        return asdict(self)

    def value(self, part: str, measure: str) -> float | None:
        """One score, such as ``freespace`` and ``iou``; None where there is none, or it is NaN."""
        found = getattr(self, part)
        return None if found is None else number_or_none(getattr(found, measure))

    @classmethod
    def from_json(cls, values: Mapping[str, Mapping[str, float] | None]) -> "MethodScores":
        """The scores from the values of :meth:`as_json`."""

        def counts(part: str) -> MaskCounts | None:
            found = values[part]
            if found is None:
                return None
            return MaskCounts(**{key: int(value) for key, value in found.items()})

        def depth(part: str) -> DepthScores | None:
            found = values[part]
            return None if found is None else DepthScores(**found)

        return cls(
            counts("freespace"),
            counts("footprint"),
            counts("visible_ground"),
            depth("ground_depth"),
            depth("visible_depth"),
        )


def score(
    predictions: Mapping[str, Prediction],
    ground_truth: GroundTruth,
    name: str,
    boxes: tuple[Box, ...] | None = None,
    voxels: VoxelGrid | None = None,
) -> dict[str, MethodScores]:
    """Scores of every baseline and model that applies to an image.

    Args:
        predictions: predictions by the name of the row; baselines start from the first one.
        ground_truth: the ground truth of the image.
        name: name of the image; it seeds random baselines.
        boxes: objects in the image, if known.
        voxels: the scene in voxels, if known.
    """
    scores = {}
    if ground_truth.ground is not None or ground_truth.ground_depth_m is not None:
        first = next(iter(predictions.values()))
        for row, estimate in baselines(first, ground_truth, name, boxes, voxels):
            scores[row] = judge(estimate, ground_truth)
    for row, prediction in predictions.items():
        scores[row] = judge(estimate_of(prediction, ground_truth.size), ground_truth)
    return scores


def judge(estimate: Estimate, ground_truth: GroundTruth) -> MethodScores:
    """Scores of an estimate against the ground truth."""
    freespace = footprint = visible_ground = ground_depth = visible_depth = None
    if estimate.ground is not None and ground_truth.ground is not None:
        ground = (estimate.ground, ground_truth.ground.mask, ground_truth.ground.valid)
        freespace = metrics.freespace(*ground)
        if ground_truth.region is not None:
            footprint = metrics.footprint(*ground, ground_truth.region)
    if estimate.visible_ground is not None and ground_truth.visible_ground is not None:
        visible_ground = metrics.freespace(
            estimate.visible_ground,
            ground_truth.visible_ground.mask,
            ground_truth.visible_ground.valid,
        )
    if estimate.ground_depth_m is not None and ground_truth.ground_depth_m is not None:
        ground_depth = metrics.depth(estimate.ground_depth_m, ground_truth.ground_depth_m)
    if estimate.visible_depth_m is not None and ground_truth.visible_depth_m is not None:
        visible_depth = metrics.depth(estimate.visible_depth_m, ground_truth.visible_depth_m)
    return MethodScores(freespace, footprint, visible_ground, ground_depth, visible_depth)
