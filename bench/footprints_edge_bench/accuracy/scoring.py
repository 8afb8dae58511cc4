"""Scores of every method on one image."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from footprints_edge.prediction import Prediction
from footprints_edge_bench.accuracy import metrics
from footprints_edge_bench.accuracy.baselines import Estimate, baselines, estimate_of
from footprints_edge_bench.accuracy.metrics import (
    DepthScores,
    MaskCounts,
    RankingCounts,
    number_or_none,
)
from footprints_edge_bench.geometry.boxes import Box
from footprints_edge_bench.geometry.voxels import VoxelGrid
from footprints_edge_bench.ground_truth.base import GroundTruth

FEWEST_HIDDEN_PX = 200
"""Images with no more hidden free ground do not count for the share of it that is found."""


@dataclass(frozen=True)
class MethodScores:
    """Scores of one method on one image; None where the method or the ground truth has no map.

    Attributes:
        freespace: S* over the image.
        footprint: pixels that are not S*, in the footprint region.
        visible_ground: S over the image.
        ground_depth: D*, the paper's hidden depth.
        visible_depth: D.
        hidden_ground: S* over hidden free ground; its recall is the share found.
        outside: S* where there is neither ground nor a footprint; its recall is the share called
            ground by mistake.
        ranking: S* of hidden free ground against S* of footprints.
        ground_border: S* near its true border; its recall is the share that is right.
        visible_border: S, likewise.
    """

    freespace: MaskCounts | None = None
    footprint: MaskCounts | None = None
    visible_ground: MaskCounts | None = None
    ground_depth: DepthScores | None = None
    visible_depth: DepthScores | None = None
    hidden_ground: MaskCounts | None = None
    outside: MaskCounts | None = None
    ranking: RankingCounts | None = None
    ground_border: MaskCounts | None = None
    visible_border: MaskCounts | None = None

    def as_json(self) -> dict[str, dict[str, Any] | None]:
        """Plain values, as :meth:`from_json` takes them."""
        return asdict(self)

    def value(self, part: str, measure: str) -> float | None:
        """One score, such as ``freespace`` and ``iou``; None where there is none, or it is NaN."""
        found = getattr(self, part)
        return None if found is None else number_or_none(getattr(found, measure))

    @classmethod
    def from_json(cls, values: Mapping[str, Mapping[str, Any] | None]) -> "MethodScores":
        """The scores from the values of :meth:`as_json`."""

        def counts(part: str) -> MaskCounts | None:
            found = values.get(part)
            if found is None:
                return None
            return MaskCounts(**{key: int(value) for key, value in found.items()})

        def depth(part: str) -> DepthScores | None:
            found = values[part]
            return None if found is None else DepthScores(**found)

        ranked = values.get("ranking")
        return cls(
            counts("freespace"),
            counts("footprint"),
            counts("visible_ground"),
            depth("ground_depth"),
            depth("visible_depth"),
            counts("hidden_ground"),
            counts("outside"),
            None if ranked is None else RankingCounts(**{k: tuple(v) for k, v in ranked.items()}),
            counts("ground_border"),
            counts("visible_border"),
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
    ground_border = visible_border = None
    if estimate.ground is not None and ground_truth.ground is not None:
        ground = (estimate.ground, ground_truth.ground.mask, ground_truth.ground.valid)
        freespace = metrics.freespace(*ground)
        ground_border = metrics.border(*ground)
        if ground_truth.region is not None:
            footprint = metrics.footprint(*ground, ground_truth.region)
    if estimate.visible_ground is not None and ground_truth.visible_ground is not None:
        seen = ground_truth.visible_ground
        visible_ground = metrics.freespace(estimate.visible_ground, seen.mask, seen.valid)
        visible_border = metrics.border(estimate.visible_ground, seen.mask, seen.valid)
    if estimate.ground_depth_m is not None and ground_truth.ground_depth_m is not None:
        ground_depth = metrics.depth(estimate.ground_depth_m, ground_truth.ground_depth_m)
    if estimate.visible_depth_m is not None and ground_truth.visible_depth_m is not None:
        visible_depth = metrics.depth(estimate.visible_depth_m, ground_truth.visible_depth_m)
    return MethodScores(
        freespace,
        footprint,
        visible_ground,
        ground_depth,
        visible_depth,
        *_behind_things(estimate, ground_truth),
        ground_border,
        visible_border,
    )


def _behind_things(
    estimate: Estimate, ground_truth: GroundTruth
) -> tuple[MaskCounts | None, MaskCounts | None, RankingCounts | None]:
    """Scores of what stands where: hidden ground found, ground by mistake, and the ranking."""
    ground, visible = ground_truth.ground, ground_truth.visible_ground
    taken = ground_truth.footprints
    if estimate.ground is None or ground is None or visible is None or taken is None:
        return None, None, None
    free = ground.mask & ~visible.mask & ground.valid & visible.valid
    enough = int(free.sum()) > FEWEST_HIDDEN_PX
    ranked = None
    if estimate.ground_probability is not None:
        ranked = metrics.ranking(estimate.ground_probability, free, taken)
    return (
        metrics.covered(estimate.ground, free) if enough else None,
        metrics.covered(estimate.ground, ~taken & ~ground.mask & ground.valid),
        ranked,
    )
