"""The paper's scores of one image (section "Experiments", "Metrics"), as in its published code.

Masks give pixel counts, from which scores are computed. Counts of several images can be added, so
scores over all pixels are possible as well as the paper's means over images.
"""

import math
import operator
from dataclasses import dataclass

import numpy as np

from footprints_edge.foundation.types import Floats, Mask

BINS = 256
"""Steps of probability in which `RankingCounts` counts."""

BORDER_PX = 3
"""Pixels no farther than this from a true border count for how exact a border is."""

DEPTH_RANGE_M = (0.5, 20.0)
"""True and predicted depths are clipped to this range before they are compared."""


@dataclass(frozen=True)
class MaskCounts:
    """Pixel counts of a predicted and a true mask, without unscored pixels.

    All scores are NaN where the true mask is empty; means skip such images.

    Attributes:
        overlap: pixels in both masks.
        predicted: pixels in the predicted mask.
        true: pixels in the true mask.
    """

    overlap: int
    predicted: int
    true: int

    def __add__(self, other: "MaskCounts") -> "MaskCounts":
        """The counts of both images added."""
        return MaskCounts(
            self.overlap + other.overlap, self.predicted + other.predicted, self.true + other.true
        )

    @property
    def iou(self) -> float:
        """Intersection over union."""
        return self._share(self.overlap, self.predicted + self.true - self.overlap)

    @property
    def precision(self) -> float:
        """Share of the predicted pixels that are true; 0 where none is predicted."""
        return self._share(self.overlap, self.predicted)

    @property
    def recall(self) -> float:
        """Share of the true pixels that are predicted."""
        return self._share(self.overlap, self.true)

    @property
    def f1(self) -> float:
        """Harmonic mean of precision and recall; 0 where both are 0."""
        return self._share(2 * self.overlap, self.predicted + self.true)

    def _share(self, part: int, whole: int) -> float:
        if self.true == 0:
            return math.nan
        return part / whole if whole else 0.0


@dataclass(frozen=True)
class RankingCounts:
    """How S* ranks hidden free ground and footprints, as counts of pixels by its probability.

    Whoever knows what stands where gives hidden free ground the higher probability. Freespace IoU
    hardly shows it, since visible ground dominates, and thresholds hide it.

    Attributes:
        free: pixels of hidden free ground, by probability in `BINS` equal steps from 0 to 1.
        footprint: pixels of footprints, likewise.
    """

    free: tuple[int, ...] = (0,) * BINS
    footprint: tuple[int, ...] = (0,) * BINS

    def __add__(self, other: "RankingCounts") -> "RankingCounts":
        """The counts of both images together."""
        return RankingCounts(
            tuple(map(operator.add, self.free, other.free)),
            tuple(map(operator.add, self.footprint, other.footprint)),
        )

    @property
    def auc(self) -> float:
        """Probability that hidden free ground is ranked above a footprint; 0.5 is chance.

        The area under the ROC curve; pixels of one step count half. NaN without pixels of a kind.
        """
        free, footprint = np.array(self.free, float), np.array(self.footprint, float)
        if not free.sum() or not footprint.sum():
            return math.nan
        below = np.cumsum(footprint) - footprint / 2
        return float((free * below).sum() / (free.sum() * footprint.sum()))


@dataclass(frozen=True)
class DepthScores:
    """Errors of a depth map; NaN where there is no true depth.

    Attributes:
        a1: share of pixels whose depth is within a factor of 1.25 (delta < 1.25).
        rmse: root mean squared error, metres.
        abs_rel: mean of the absolute error over the true depth.
        sq_rel: mean of the squared error over the true depth, metres.
    """

    a1: float
    rmse: float
    abs_rel: float
    sq_rel: float


def freespace(predicted: Mask, true: Mask, valid: Mask) -> MaskCounts:
    """Counts over an image: the paper's freespace evaluation, also used for visible ground.

    Args:
        predicted: bool (H, W).
        true: bool (H, W).
        valid: bool (H, W), where the ground truth is valid; other pixels are not scored.
    """
    return MaskCounts(
        int((predicted & true & valid).sum()),
        int((predicted & valid).sum()),
        int((true & valid).sum()),
    )


def footprint(predicted: Mask, true: Mask, valid: Mask, region: Mask) -> MaskCounts:
    """Counts of pixels that are not ground, in a region: the paper's footprint evaluation.

    Args:
        predicted: bool (H, W), ground.
        true: bool (H, W), ground.
        valid: bool (H, W), where the ground truth is valid.
        region: bool (H, W), the ground with the objects on it.
    """
    return freespace(~predicted, ~true, valid & region)


def covered(predicted: Mask, region: Mask) -> MaskCounts:
    """Counts whose recall is the share of a region that is predicted.

    Args:
        predicted: bool (H, W).
        region: bool (H, W), such as hidden free ground.
    """
    overlap = int((predicted & region).sum())
    return MaskCounts(overlap, overlap, int(region.sum()))


def border(predicted: Mask, true: Mask, valid: Mask) -> MaskCounts:
    """Counts whose recall is the share of pixels near the true border that are right.

    Near are pixels that have true ground and true non-ground, both valid, within `BORDER_PX`: where
    ground ends at what is not scored, there is no border. Everything and nothing score about 0.5.

    Args:
        predicted: bool (H, W).
        true: bool (H, W).
        valid: bool (H, W), where the ground truth is valid.
    """
    near = valid & _within(BORDER_PX, true & valid) & _within(BORDER_PX, ~true & valid)
    return covered(predicted == true, near)


def _within(radius_px: int, mask: Mask) -> Mask:
    """Pixels at most so far from one of the mask, bool (H, W)."""
    import cv2

    distance_px = cv2.distanceTransform(
        (~mask).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE
    )
    return np.asarray(distance_px <= radius_px)


def ranking(probability: Floats, free: Mask, footprint: Mask) -> RankingCounts:
    """Counts of two kinds of pixels by the probability of ground.

    Args:
        probability: float32 (H, W), S*.
        free: bool (H, W), hidden free ground.
        footprint: bool (H, W), footprints.
    """
    step = np.minimum((np.clip(probability, 0, 1) * BINS).astype(np.intp), BINS - 1)
    counts = (np.bincount(step[where], minlength=BINS).tolist() for where in (free, footprint))
    return RankingCounts(*map(tuple, counts))


def depth(predicted_m: Floats, true_m: Floats) -> DepthScores:
    """Errors of a depth map over the pixels whose true depth is known.

    Args:
        predicted_m: (H, W), metres; infinite counts as the farthest depth, NaN as the nearest.
        true_m: (H, W), metres, 0 where unknown.
    """
    valid = true_m > 0
    if not valid.any():
        return DepthScores(math.nan, math.nan, math.nan, math.nan)
    true = np.clip(true_m[valid].astype(np.float64), *DEPTH_RANGE_M)
    predicted = np.nan_to_num(predicted_m[valid].astype(np.float64), nan=0.0, posinf=np.inf)
    predicted = np.clip(predicted, *DEPTH_RANGE_M)
    error = np.abs(predicted - true)
    return DepthScores(
        a1=float((np.maximum(predicted / true, true / predicted) < 1.25).mean()),
        rmse=float(np.sqrt((error**2).mean())),
        abs_rel=float((error / true).mean()),
        sq_rel=float((error**2 / true).mean()),
    )


def number_or_none(value: float) -> float | None:
    """A score for JSON, which has no NaN: None instead."""
    return None if math.isnan(value) else value
