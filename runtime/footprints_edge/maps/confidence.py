"""How far a result is to be believed: whether the picture shows ground, and its metres.

Both are probabilities, from a few inputs each by a logistic curve that rises with every input. The
numbers of the curves are in `confidence.json`, which `fp-bench confidence --refit` writes for a new
model; nothing here depends on one.
"""

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from footprints_edge.foundation.types import Floats, Mask
from footprints_edge.geometry.camera import Intrinsics
from footprints_edge.geometry.ground_plane import GroundPlane

CURVES_FILE = Path(__file__).with_name("confidence.json")

GROUND_INPUTS = ("peak", "clear_top")
METRES_INPUTS = ("flatness", "agreement", "evenness", "area", "steepness")

_LEAST_PX = 20

_LEAST_SURE = 0.002473
"""Nearer to 0 and 1, int8 probabilities are rounded: ln(p / (1 - p)) stays between -6 and 6."""


@dataclass(frozen=True)
class Confidence:
    """What a prediction is worth, as probabilities from 0 to 1.

    Attributes:
        ground: That the picture shows ground, and the visible ground is most of what is drawn (IoU
            of at least a half), if pictures with and without ground are equally frequent.
        metres: That distances on the ground are right within a quarter in the median, if the lens
            is the stated one. NaN without a ground plane; 1 where the camera's height, pitch and
            roll are known.
    """

    ground: float
    metres: float


@dataclass(frozen=True)
class Curve:
    """A logistic curve: 1 / (1 + exp(-(offset + sum of weight * input)))."""

    offset: float
    weights: Mapping[str, float]

    @property
    def used(self) -> tuple[str, ...]:
        """The inputs that matter."""
        return tuple(name for name, weight in self.weights.items() if weight)

    def at(self, inputs: Mapping[str, float]) -> float:
        """The probability for inputs by name, of which `used` are needed."""
        logit = self.offset + sum(self.weights[name] * inputs[name] for name in self.used)
        return 1 / (1 + math.exp(-max(-50.0, min(50.0, logit))))


@dataclass(frozen=True)
class Curves:
    """The content of `confidence.json`.

    Attributes:
        ground: For `Confidence.ground`.
        metres: For `Confidence.metres`.
        least_ground: Below this `Confidence.ground` there is no ground: no plane, no map, and
            nothing is drawn.
    """

    ground: Curve
    metres: Curve
    least_ground: float

    def least_peak(self, clear_top: float) -> float:
        """The probability of the surest ground at `least_ground`, see `ground_inputs`."""
        logit = math.log(self.least_ground / (1 - self.least_ground)) - self.ground.offset
        logit -= self.ground.weights["clear_top"] * clear_top
        return 1 / (1 + math.exp(-logit / self.ground.weights["peak"]))

    def to_json(self) -> str:
        """The text of the file."""
        facts = {
            "ground": {"offset": self.ground.offset, "weights": dict(self.ground.weights)},
            "metres": {"offset": self.metres.offset, "weights": dict(self.metres.weights)},
            "least_ground": self.least_ground,
        }
        return json.dumps(facts, indent=2) + "\n"


@cache
def curves() -> Curves:
    """Reads `confidence.json`."""
    facts = json.loads(CURVES_FILE.read_text(encoding="utf-8"))
    ground, metres = (
        Curve(facts[name]["offset"], facts[name]["weights"]) for name in ("ground", "metres")
    )
    return Curves(ground, metres, facts["least_ground"])


def ground_inputs(ground_probability: Floats) -> dict[str, float]:
    """What tells whether there is ground.

    Args:
        ground_probability: float32 (h, w), the paper's S*.

    Returns:
        `peak`: how sure the network is of its surest ground, ln(p / (1 - p)) of the 98th percentile
        p of S*, from -6 to 6; `clear_top`: 1 less the mean of S* over the upper quarter of the
        picture, as a wall that looks like ground does so up to the upper border. Area, nearness to
        the lower border, agreement of both depths, and how unsure the rest of the picture is, were
        tried beside them and tell nothing more.
    """
    values = ground_probability.ravel()
    at = _place_of_peak(values.size)
    p = min(max(float(np.partition(values, at)[at]), _LEAST_SURE), 1 - _LEAST_SURE)
    return {"peak": math.log(p / (1 - p)), "clear_top": _clear_top(ground_probability)}


def shows_ground(ground_probability: Floats) -> bool:
    """Whether `Confidence.ground` is at least `Curves.least_ground`.

    Counting is a tenth of the work of finding the percentile, and this is asked of every picture.
    """
    least = curves().least_peak(_clear_top(ground_probability))
    sure = np.count_nonzero(ground_probability >= np.float32(least))
    enough = ground_probability.size - _place_of_peak(ground_probability.size)
    return least <= 1 - _LEAST_SURE and bool(sure >= enough)


def _clear_top(ground_probability: Floats) -> float:
    upper = ground_probability[: max(1, len(ground_probability) // 4)]
    return 1 - float(upper.mean(dtype=np.float64))


def _place_of_peak(pixels: int) -> int:
    """The place of the 98th percentile among probabilities in ascending order."""
    return int(0.98 * (pixels - 1))


def metres_inputs(
    plane: GroundPlane,
    visible_depth_m: Floats,
    visible_ground: Mask,
    intrinsics: Intrinsics,
    wanted: Sequence[str] = METRES_INPUTS,
) -> dict[str, float]:
    """What tells whether metres are right; more is better.

    Args:
        plane: The ground plane that was fitted.
        visible_depth_m: float32 (h, w), metres, by the network, not laid onto the plane.
        visible_ground: bool (h, w).
        intrinsics: The camera in pixels of (h, w).
        wanted: The inputs to compute.

    Returns:
        `flatness`: how little the ground's depth deviates from the plane, -ln(error / height);
        `agreement`: how little the visible depth of visible ground is longer or shorter than the
        plane's, -|ln(ratio)|; `evenness`: how little that ratio varies; `area`: square root of the
        share of the picture that is visible ground; `steepness`: sine of the pitch, as a camera
        that looks down sees the ground at less of an angle.
    """
    found = {
        "flatness": -math.log(plane.error_m / plane.camera_height_m + 0.005),
        "area": math.sqrt(np.count_nonzero(visible_ground) / visible_ground.size),
        "steepness": -float(plane.up[2]),
    }
    if {"agreement", "evenness"} & set(wanted):
        found |= _agreement(plane, visible_depth_m, visible_ground, intrinsics, wanted)
    return {name: found[name] for name in wanted}


def _agreement(
    plane: GroundPlane,
    visible_depth_m: Floats,
    visible_ground: Mask,
    intrinsics: Intrinsics,
    wanted: Sequence[str],
) -> dict[str, float]:
    height, width = visible_ground.shape
    inverse_m = plane.inverse_depth(intrinsics, (height, width))
    seen = visible_ground & (inverse_m > 1e-3)
    agreement, evenness = -1.0, -1.0
    if np.count_nonzero(seen) >= _LEAST_PX:
        ratio = np.log(visible_depth_m[seen] * inverse_m[seen])
        middle = float(np.median(ratio))
        agreement = max(-1.0, -abs(middle))
        if "evenness" in wanted:
            evenness = max(-1.0, -float(np.median(np.abs(ratio - middle))))
    return {"agreement": agreement, "evenness": evenness}
